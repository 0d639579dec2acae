"""A line of JSON for each tick, into a file or to whoever reads our output."""

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import IO

from ballscrew.monitor.beside import Beside
from ballscrew.monitor.status import Status
from ballscrew.terminal import STDOUT, plain
from estimator.errors import SetupError

DIGITS = 16  # the same estimate as review's, to the last
WAITING = 1000  # lines that wait for their reader; then new ones are lost


class JsonLines:
    """Has the lines written beside the monitor, which a reader that stalls must not hold up.

    A full disk, and a reader that is gone or behind, cost lines, and are told in `trouble`. `file` is not buffered.
    """

    def __init__(self, file: IO[bytes]) -> None:
        self._file, self._beside = file, Beside(WAITING)
        self._wrong, self._failed, self._late = "", 0, 0
        self.close = self._beside.close

    def __call__(self, status: Status) -> None:
        line = json.dumps(plain(status.json(), DIGITS)).encode() + b"\n"
        self._late += not self._beside(partial(self._write, line))

    @property
    def lost(self) -> int:
        """Lines that nobody will read."""
        return self._failed + self._late

    @property
    def trouble(self) -> str:
        """Why lines are lost now; "" where none are."""
        why = "their reader is behind" if self._beside.full else self._wrong
        return why and f"--json: {why}: lines are lost"

    def _write(self, line: bytes) -> None:
        try:
            self._file.write(b"\n" + line if self._wrong else line)  # after a line that was torn
            self._wrong = ""
        except (OSError, ValueError) as error:  # ValueError: closed
            self._failed += 1
            self._wrong = getattr(error, "strerror", None) or str(error)


@contextmanager
def json_lines(path: str | None) -> Iterator[JsonLines | None]:
    """Who writes them; None where nobody asked."""
    if path is None:
        yield None
        return
    try:  # a file of its own for our output, too: a writer that waits for ever would hold up the end of Python
        at = os.dup(sys.stdout.fileno()) if path == STDOUT else path
        file = open(at, "wb", buffering=0)  # noqa: SIM115 - its writer may be at it to the very end
    except OSError as error:
        raise SetupError(f"--json {path}: {error.strerror}; name another file") from error
    lines = JsonLines(file)
    yield lines
    lines.close()
