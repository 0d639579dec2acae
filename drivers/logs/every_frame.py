"""Every frame of a log, of every kind and one after the other: for who passes them on and does not estimate."""

import marshal
import math
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

from drivers.budget import Budget
from drivers.frames import LATEST_S, Frames, Tally
from drivers.lab.frame_table import read_frame_table
from drivers.logs.candump_line import frame_of
from drivers.logs.lines import WholeLines
from drivers.logs.logs import is_frame_table, is_lab_csv
from drivers.logs.outside import EVERY, Outside
from drivers.received import Received
from estimator.errors import InputError

Position = Callable[[int], None]
UNLIMITED = Budget(frames=sys.maxsize, seconds=math.inf)  # in length: years may be passed on, a loop may not


def every_frame(path: Path, tally: Tally, position: Position = lambda byte: None) -> Iterator[Received]:
    """The frames in the order of the log; `tally` is told what is none, `position` how many bytes are read.

    What cannot be a log of frames is an InputError; a torn one is read up to the tear.
    """
    if is_lab_csv(path):
        raise InputError(f"{path}: a lab CSV holds no frames")
    reader = _table if is_frame_table(path) else _candump if path.suffix.lower() == ".log" else _python_can
    for frame in reader(path, tally, position):
        if 0 <= frame.time_s < LATEST_S:
            yield frame
        else:
            tally.skip("time stamp absurd")


def _candump(path: Path, tally: Tally, position: Position) -> Iterator[Received]:
    with closing(WholeLines(path)) as lines:
        for line in lines:
            if lines.count % 1000 == 0:
                position(lines.tell())
            if frame := frame_of(line):
                yield frame
            elif not line.isspace():
                tally.skip("torn or foreign line")
        lines.account(tally)


def _table(path: Path, tally: Tally, position: Position) -> Iterator[Received]:
    frames, _ = read_frame_table(path, tally, UNLIMITED)
    position(path.stat().st_size)
    yield from one_by_one(frames)


def one_by_one(frames: Frames) -> Iterator[Received]:
    """Data frames of a log as they came off their bus."""
    for k, bus in enumerate(frames.bus):
        data = frames.data[k, : frames.dlc[k]].tobytes()
        about = float(frames.time[k]), int(frames.id[k]), bool(frames.extended[k]), data
        yield Received(*about, "data", frames.buses[bus], len(data))


def _python_can(path: Path, tally: Tally, position: Position) -> Iterator[Received]:
    size = path.stat().st_size
    for block in Outside(path, tally, UNLIMITED, EVERY):
        position(int(min(block.share, 1.0) * size))
        yield from (Received(*row) for row in marshal.loads(block.body))
