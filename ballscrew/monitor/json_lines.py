"""A line of JSON for each tick, into a file or to whoever reads our output."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from queue import Full, Queue
from threading import Thread
from typing import IO

from ballscrew.monitor.status import Status
from ballscrew.options import STDOUT
from ballscrew.terminal import plain
from estimator.errors import SetupError

DIGITS = 16  # the same estimate as review's, to the last
WAITING = 1000  # lines that wait for their reader; then new ones are lost
END_S = 1.0  # that the last ones have at the end


class JsonLines:
    """Has the lines written beside the monitor, which a reader that stalls must not hold up.

    A full disk, and a reader that is gone or behind, cost lines, and are told in `trouble`. `file` is not buffered.
    """

    def __init__(self, file: IO[bytes]) -> None:
        self._file, self._waiting = file, Queue[bytes | None](WAITING)
        self._wrong, self._failed, self._late = "", 0, 0
        self._writer = Thread(target=self._write, daemon=True)
        self._writer.start()

    def __call__(self, status: Status) -> None:
        try:
            self._waiting.put_nowait(json.dumps(plain(status.json(), DIGITS)).encode() + b"\n")
        except Full:
            self._late += 1

    @property
    def lost(self) -> int:
        """Lines that nobody will read."""
        return self._failed + self._late

    @property
    def trouble(self) -> str:
        """Why lines are lost now; "" where none are."""
        why = "their reader is behind" if self._waiting.full() else self._wrong
        return why and f"--json: {why}: lines are lost"

    def close(self) -> None:
        """Write what waits, as far as the reader takes it."""
        with suppress(Full):
            self._waiting.put(None, timeout=END_S)
        self._writer.join(END_S)

    def _write(self) -> None:
        while (line := self._waiting.get()) is not None:
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
