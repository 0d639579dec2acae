"""Text logs line by line, as python-can takes them."""

import io
import re
from collections.abc import Iterator
from contextlib import closing
from itertools import islice
from pathlib import Path

import numpy as np

from drivers.frames import Tally, falls_again_and_again

_LONGEST_LINE = 4096
_ASC_TIME = re.compile(r"\s*(-?\d+\.\d+)(?=\s+(\S+))")
_RELATIVE = re.compile(r"\s*base\s+\w+\s+timestamps\s+relative", re.IGNORECASE)
_ASC_HEAD = re.compile(r"\s*(date\s|base\s|//)", re.IGNORECASE)
_ASC_EVENTS = re.compile(r"\s*(no)?\s*internal\s+events\s+logged", re.IGNORECASE)
_FD_LINE = re.compile(
    r"(\s*-?\d+\.\d+ +)CANFD +(\d+) +(Rx|Tx) +(\w+) +(?:[^\d\s]\S* +)?[01] +[01] +([0-8]) +\d "
    r"((?: *[0-9A-Fa-f]{2}\b){0,8}) +\d+ +\d+ +([0-9A-Fa-f]+) .*",
    re.DOTALL,
)
_FD = 0x1000  # in its flags
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
    """The lines of a Vector .asc, with times that count from one zero, none of them negative, below a whole head.

    Where the head says `timestamps relative`, each counts from the line before; it is wrong if they only rise, or where
    it does not say so, if they go up and down. Times before the trigger are negative: all are moved on by `shift_s`.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        with closing(WholeLines(path)) as lines:
            head = list(islice(lines, _PEEK))
        found = [match for match in map(_ASC_TIME.match, head) if match]
        times = np.array([float(match[1]) for match in found])
        one_clock = np.array([time for time, match in zip(times, found) if match[2] == found[-1][2]])
        rising = len(times) > _FEW and bool((np.diff(times) >= 0).all() and times[-1] > times[0])
        falling = len(one_clock) > _FEW and falls_again_and_again(one_clock)
        said = any(map(_RELATIVE.match, head))
        self.relative = (said and not rising) or falling
        self.wrong = (
            "its times only rise" if said and rising else "times go up and down" if falling and not said else ""
        )
        self.shift_s = max(-float(times.min(initial=0.0)), 0.0)
        self._now = 0.0
        self._head, self._waiting = True, ""

    def __next__(self) -> str:
        text = self._waiting or super().__next__()
        self._waiting = ""
        if self._head and not _ASC_HEAD.match(text):
            self._head = False
            if not _ASC_EVENTS.match(text):  # python-can takes the first line after the head for this one
                self._waiting = text
                return "no internal events logged\n"
        fd = _FD_LINE.fullmatch(text) if " CANFD " in text else None
        if fd and not int(fd[7], 16) & _FD:  # a classic frame on a bus that can have others
            text = f"{fd[1]}{fd[2]}  {fd[4]}  {fd[3]}   d {fd[5]} {fd[6].strip()}\n"
        match = _ASC_TIME.match(text) if self.relative or self.shift_s else None
        if match is None:
            return text
        self._now = float(match[1]) + (self._now if self.relative else 0.0)
        return f"{self._now + self.shift_s:.6f}{text[match.end() :]}"

    def account(self, tally: Tally) -> None:
        """Tell of times that are not what the head says, too."""
        super().account(tally)
        if self.wrong:
            taken = "from the line before" if self.relative else "from one zero"
            tally.note(f"its head says otherwise, but {self.wrong}: taken as counting {taken}")
