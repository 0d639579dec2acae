"""A line of JSON for each tick, into a file or to whoever reads our output."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO

from ballscrew.monitor.status import Status
from ballscrew.options import STDOUT
from ballscrew.terminal import plain
from estimator.errors import SetupError

DIGITS = 16  # the same estimate as review's, to the last


class JsonLines:
    """Writes the lines; a full disk or a reader that is gone costs lines, and is told in `trouble`."""

    def __init__(self, file: IO[str]) -> None:
        self.trouble, self.lost = "", 0
        self._file = file

    def __call__(self, status: Status) -> None:
        text = json.dumps(plain(status.json(), DIGITS))
        try:
            self._file.write(f"\n{text}\n" if self.trouble else f"{text}\n")  # after a line that was torn
            self._file.flush()
            self.trouble = ""
        except (OSError, ValueError) as error:  # ValueError: closed
            self.lost += 1
            self.trouble = f"--json: {getattr(error, 'strerror', None) or error}: lines are lost"


@contextmanager
def json_lines(path: str | None) -> Iterator[JsonLines | None]:
    """Who writes them; None where nobody asked."""
    if path is None:
        yield None
        return
    with ExitStack() as opened:
        file = sys.stdout
        if path != STDOUT:
            try:
                file = Path(path).open("w")  # noqa: SIM115 - a full disk must not spoil the end
            except OSError as error:
                raise SetupError(f"--json {path}: {error.strerror}; name another file") from error
            opened.callback(_close, file)
        yield JsonLines(file)


def _close(file: IO[str]) -> None:
    with suppress(OSError):
        file.close()
