"""Every frame of a log, of every kind and one after the other: for who passes them on and does not estimate."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path

import can

from drivers.frames import LATEST_S, Tally
from drivers.logs.candump_line import frame_of
from drivers.logs.logs import is_lab_csv, regular
from drivers.logs.outside_reader import WholeLines
from drivers.received import Received, received_of
from estimator.errors import InputError

_READERS = {
    ".asc": can.ASCReader,
    ".blf": can.BLFReader,
    ".csv": can.CSVReader,
    ".mf4": can.MF4Reader,
    ".trc": can.TRCReader,
}
_TEXT = {".asc", ".csv", ".trc"}
_LONGEST = 4096  # bytes of a line

Position = Callable[[int], None]


def every_frame(path: Path, tally: Tally, position: Position = lambda byte: None) -> Iterator[Received]:
    """The frames in the order of the log; `tally` is told what is none, `position` how many bytes are read.

    What cannot be a log of frames is an InputError; a torn one is read up to the tear.
    """
    suffix = regular(path).suffix.lower()
    if is_lab_csv(path):
        raise InputError(f"{path}: a lab CSV holds no frames")
    if suffix == ".mf4" and find_spec("asammdf") is None:
        raise InputError(f"{path}: reading MF4 needs asammdf: pip install 'ballscrew[mf4]'")
    for frame in _candump(path, tally, position) if suffix == ".log" else _outside(path, tally, position):
        if 0 <= frame.time_s < LATEST_S:
            yield frame
        else:
            tally.skip("time stamp absurd")


def _candump(path: Path, tally: Tally, position: Position) -> Iterator[Received]:
    with path.open("rb") as file:
        line, number, whole = b"\n", 0, True
        while piece := file.readline(_LONGEST):
            number += whole  # else the rest of a line that is too long for a frame
            line, whole = piece if whole else b"", piece.endswith(b"\n")
            if not whole:
                continue
            if number % 1000 == 0:
                position(file.tell())
            if frame := frame_of(line.decode("latin-1")):
                yield frame
            elif not line.isspace():
                tally.skip("torn or foreign line")
        if not whole:
            tally.skip("torn line")
            tally.note(f"torn at line {number}: it has no line end; read up to there")


def _outside(path: Path, tally: Tally, position: Position, absolute: bool = True) -> Iterator[Received]:
    """What python-can reads; whatever it raises on a broken file, the frames before it count."""
    suffix = path.suffix.lower()
    lines = WholeLines(str(path)) if suffix in _TEXT else None
    count = 0
    try:
        with _READERS[suffix](lines or str(path), relative_timestamp=not absolute) as reader:
            for count, message in enumerate(reader, 1):
                if count % 1000 == 0 and suffix != ".mf4":
                    position(reader.file.tell())
                if message.is_remote_frame or len(message.data) == message.dlc:
                    yield received_of(message, message.timestamp, _channel(message, suffix == ".trc"))
                else:
                    tally.skip("shortened frame")
    except Exception as error:
        if absolute and not count and suffix == ".asc" and "datetime" in str(error):
            tally.note("its date cannot be read: times count from 1970")
            yield from _outside(path, tally, position, absolute=False)
            return
        why = " ".join(str(error).split())[:120]
        tally.note(f"torn at frame {count + 1}: {type(error).__name__}: {why}; read up to there")
    if lines and lines.torn:
        tally.skip("torn line")
        tally.note(f"torn at line {lines.count}: it has no line end; read up to there")
    if suffix == ".blf" and (told := _told_size(path)) not in (0, path.stat().st_size):
        # python-can takes half a container for a whole one
        tally.note(f"torn at frame {count + 1}: its head says {told} bytes, {path.stat().st_size} are there")


def _told_size(path: Path) -> int:
    """The length that the head of a BLF file tells, bytes; 0 for another file."""
    with path.open("rb") as file:
        head = file.read(24)
    return int.from_bytes(head[16:24], "little") if head.startswith(b"LOGG") else 0


def _channel(message: can.Message, first: int) -> str:
    """A channel's name; formats that number their channels count from `first`."""
    if isinstance(message.channel, str) and not message.channel.isdigit():
        return message.channel
    return f"can{max(int(message.channel or 0) - first, 0)}"
