"""candump text, `(1699999999.123456) can0 210#0011223344556677`, from bytes to arrays in bulk.

Lines of one layout (same length, digits and hex in the same columns) are cut out as a matrix and decoded together; the
layout is taken from a line that matches the pattern, so nothing is assumed about interface names or digits. A line
that matches nothing is counted, and a last line without its line end is never a frame: its data may be cut short.
"""

import codecs
import re
import time
from collections.abc import Callable
from itertools import count
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drivers.budget import Budget
from drivers.frames import FRAME, Frames, Index, Tally, Whole
from drivers.logs.candump_line import ERROR_FLAG

Bytes = NDArray[np.uint8]

_LINE = re.compile(
    rb" *\((\d{1,10})\.(\d{1,9})\) +(\S+) +([0-9A-Fa-f]{8}|[0-9A-Fa-f]{3})#((?:[0-9A-Fa-f]{2}){0,8})( [RT])?\r?"
)
_REMOTE = re.compile(rb"\(\d+\.\d+\) \S+ [0-9A-Fa-f]{3,8}#R")
_FD = re.compile(rb"\(\d+\.\d+\) \S+ [0-9A-Fa-f]{3,8}##")
_SCREEN = re.compile(rb" {1,3}(?:\([^)]*\) +)?\S+ +(?:[RT]X \S+ \S+ +)?[0-9A-Fa-f]{3,8} +\[\d+\] ")
_FOREIGN = "torn or foreign line"
_ON_SCREEN = "line as candump shows it on the screen: record with `candump -L`"
_CHUNK = 1 << 23
_LAYOUTS = 64
_LONGEST = 256

_HEX = np.full(256, 255, np.uint8)
for _value, _digits in enumerate([*b"0123456789", *b"abcdef"]):
    _HEX[_digits] = _HEX[ord(chr(_digits).upper())] = _value


def read_candump(
    path: Path, tally: Tally, budget: Budget, progress: Callable[[float], None] | None = None
) -> tuple[Frames, str]:
    """All whole data frames of a candump log, and what was found, in words."""
    reader = _Reader(tally)
    stop = time.thread_time() + budget.seconds
    size = max(path.stat().st_size, 1)
    with path.open("rb") as file:
        rest = b""
        file.seek(len(codecs.BOM_UTF8) if file.read(3) == codecs.BOM_UTF8 else 0)
        while block := file.read(_CHUNK):
            rest = reader.feed(rest + block)
            if progress:
                progress(min(file.tell() / size, 1.0))
            if why := budget.spent(reader.count, file.tell(), time.thread_time() > stop):
                tally.note(f"stopped at line {reader.lines}: {why}")
                rest = b""
                break
    reader.finish(rest)
    return Frames.of(reader.blocks, "line", tuple(reader.buses) or ("can0",)), f"{reader.lines} lines read"


class _Reader:
    """Carries line numbers, counts and decoded blocks, of dtype FRAME, from chunk to chunk."""

    def __init__(self, tally: Tally) -> None:
        self.tally = tally
        self.lines = 0
        self.count = 0
        self.foreign = 0  # first line that is no frame
        self.buses: dict[str, int] = {}
        self.blocks: list[NDArray[np.void]] = [np.empty(0, FRAME)]

    def feed(self, text: bytes) -> bytes:
        """Decode the whole lines of `text`; returns what comes after the last line end."""
        buffer = np.frombuffer(text, np.uint8)
        ends = np.flatnonzero(buffer == 10)
        if not len(ends):
            return self._endless(text)
        starts = np.concatenate(([0], ends[:-1] + 1))
        self._decode(text, buffer, starts, ends - starts)
        self.lines += len(ends)
        return self._endless(text[ends[-1] + 1 :])

    def finish(self, rest: bytes) -> None:
        """Account for lines that were no frame, and for a last one without its line end."""
        if self.foreign:
            count = self.tally.skipped[_FOREIGN]
            self.tally.note(f"line {self.foreign} is no frame (the first of {count})")
        if not rest:
            return
        self.lines += 1
        zeros = rest.count(0)
        self.tally.skip("torn line")
        inside = f", {zeros} bytes of it zero" if zeros else ""
        self.tally.note(f"torn at line {self.lines}: it has no line end{inside}; read up to there")

    def _endless(self, rest: bytes) -> bytes:
        # A line that never ends (zeros after a power cut, a binary file) must not pile up in memory.
        return rest if len(rest) <= _CHUNK else rest[-_LONGEST:]

    def _decode(self, text: bytes, buffer: Bytes, starts: Index, lengths: Index) -> None:
        def line(index: int) -> bytes:
            return text[starts[index] : starts[index] + lengths[index]]

        todo, tables = np.flatnonzero(lengths > 0), []
        for attempt in count():
            layout, todo = self._layout(line, todo)
            if layout is None:
                break
            # a file of a thousand layouts is taken line by line: to look for more of each would never end
            same = todo[lengths[todo] == layout.end()] if attempt < _LAYOUTS else todo[:1]
            good, table = _cut(buffer, starts[same], layout)
            table["number"] = self.lines + 1 + same[good]
            tables.append(table)
            table["bus"] = self._bus(layout[3].decode("latin-1"))
            todo = np.setdiff1d(todo, same[good], assume_unique=True) if attempt < _LAYOUTS else todo[1:]
        if tables:
            self._keep(np.concatenate(tables))

    def _bus(self, name: str) -> int:
        return min(self.buses.setdefault(name, len(self.buses)), 255)

    def _layout(self, line: Callable[[int], bytes], todo: Index) -> tuple[re.Match[bytes] | None, Index]:
        """The match of the first line still to do that is a frame; lines before it are counted and left."""
        for position, index in enumerate(todo):
            if match := _LINE.fullmatch(line(index)):
                return match, todo[position:]
            self._odd(line(index), self.lines + 1 + int(index))
        return None, todo[:0]

    def _odd(self, line: bytes, number: int) -> None:
        if not line.strip():
            return
        kinds = {"remote frame": _REMOTE, "CAN FD frame": _FD, _ON_SCREEN: _SCREEN}
        reason = next((kind for kind, pattern in kinds.items() if pattern.match(line)), _FOREIGN)
        self.tally.skip(reason)
        if reason == _FOREIGN:
            self.foreign = min(self.foreign or number, number)

    def _keep(self, table: NDArray[np.void]) -> None:
        table = table[np.argsort(table["number"], kind="stable")]
        error = table["extended"] & ((table["id"] & ERROR_FLAG) != 0)
        if error.any():
            self.tally.skip("error frame", np.count_nonzero(error))
            table = table[~error]
        self.count += len(table)
        self.blocks.append(table)


def _cut(buffer: Bytes, starts: Index, layout: re.Match[bytes]) -> tuple[Index, NDArray[np.void]]:
    """Decode the lines at `starts` that have this layout: their indices into `starts`, and the frames."""
    text = np.lib.stride_tricks.sliding_window_view(buffer, layout.end())[starts]
    values = _HEX[text]
    free = np.zeros(layout.end(), bool)
    good = np.ones(len(starts), bool)
    for group in (1, 2, 4, 5):
        columns = slice(*layout.span(group))
        free[columns] = True
        good &= (values[:, columns] <= (9 if group < 3 else 15)).all(axis=1)
    good &= (text[:, ~free] == np.frombuffer(layout[0], np.uint8)[~free]).all(axis=1)
    index = np.flatnonzero(good)
    values = values[index]
    table = np.zeros(len(index), FRAME)
    whole, part = (_number(values[:, slice(*layout.span(g))], 10) for g in (1, 2))
    digits = 10 ** len(layout[2])
    table["time"] = whole + part / digits if len(layout[2]) > 6 else (whole * digits + part) / digits
    table["id"] = _number(values[:, slice(*layout.span(4))], 16)
    table["extended"] = len(layout[4]) == 8
    table["dlc"] = size = len(layout[5]) // 2
    data = values[:, slice(*layout.span(5))]
    table["data"][:, :size] = data[:, ::2] << 4 | data[:, 1::2]
    return index, table


def _number(digits: Bytes, base: int) -> Whole:
    number = np.zeros(len(digits), np.int64)
    for column in digits.T:
        number = number * base + column
    return number
