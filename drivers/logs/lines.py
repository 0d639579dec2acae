"""Text logs line by line, as python-can takes them."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import closing
from itertools import islice
from pathlib import Path

import numpy as np

from drivers.frames import Tally

_LONGEST_LINE = 4096
_ASC_TIME = re.compile(r"\s*(-?\d+\.\d+)(?=\s)")
_RELATIVE = re.compile(r"\s*base\s+\w+\s+timestamps\s+relative", re.IGNORECASE)
_PEEK, _FEW = 2000, 20  # lines that show whether times are what the head of an .asc says; times that show nothing


class WholeLines:
    """A text file line by line, long lines cut short; a last one without its end may be cut itself and is kept back."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("rb")
        self.tell, self.close = self._file.tell, self._file.close
        self.count = 0
        self.silent = 0  # lines since the last frame, comments left out
        self.torn = False
        self.shift_s = 0.0  # added to all times

    def __iter__(self) -> Iterator[str]:
        return self

    def __next__(self) -> str:
        line = end = self._file.readline(_LONGEST_LINE)
        while end and not end.endswith(b"\n"):
            end = self._file.readline(_LONGEST_LINE)
        self.count += bool(line)
        self.torn |= bool(line) and not end
        if not end:
            raise StopIteration
        text = line.decode("utf-8", "surrogateescape") if line.isascii() else line.decode("latin-1")
        self.silent += not text.lstrip().startswith((";", "//", "End T", "end t")) and bool(text.strip())
        return text

    def account(self, tally: Tally) -> None:
        """Tell of a last line without its end."""
        if self.torn:
            tally.skip("torn line")
            tally.note(f"torn at line {self.count}: it has no line end; read up to there")

    def read(self) -> str:
        """Only its presence counts: python-can takes what can be read for a file."""
        raise io.UnsupportedOperation("read")


class AscLines(WholeLines):
    """The lines of a Vector .asc, with times that count from one zero, none of them negative.

    Where the head says `timestamps relative`, each counts from the line before; if they only rise, it is wrong. Times
    before the trigger are negative: all are moved on by `shift_s`.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        with closing(WholeLines(path)) as lines:
            head = list(islice(lines, _PEEK))
        times = np.array([float(match[1]) for match in map(_ASC_TIME.match, head) if match])
        rising = len(times) > _FEW and bool((np.diff(times) >= 0).all() and times[-1] > times[0])
        said = any(map(_RELATIVE.match, head))
        self.relative, self.mislabelled = said and not rising, said and rising
        self.shift_s = max(-float(times.min(initial=0.0)), 0.0)
        self._now = 0.0

    def __next__(self) -> str:
        text = super().__next__()
        match = _ASC_TIME.match(text) if self.relative or self.shift_s else None
        if match is None:
            return text
        self._now = float(match[1]) + (self._now if self.relative else 0.0)
        return f"{self._now + self.shift_s:.6f}{text[match.end() :]}"

    def account(self, tally: Tally) -> None:
        """Tell of times that are not what the head says, too."""
        super().account(tally)
        if self.mislabelled:
            tally.note("its head says `timestamps relative`, but its times only rise: taken as counting from one zero")
