"""Every frame of a log, of every kind and one after the other: for who passes them on and does not estimate."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import can

from drivers.frames import LATEST_S, Tally
from drivers.logs.candump_line import frame_of
from drivers.logs.logs import is_lab_csv
from drivers.logs.python_can import Messages, WholeLines
from drivers.received import Received, received_of
from estimator.errors import InputError

Position = Callable[[int], None]


def every_frame(path: Path, tally: Tally, position: Position = lambda byte: None) -> Iterator[Received]:
    """The frames in the order of the log; `tally` is told what is none, `position` how many bytes are read.

    What cannot be a log of frames is an InputError; a torn one is read up to the tear.
    """
    if is_lab_csv(path):
        raise InputError(f"{path}: a lab CSV holds no frames")
    reader = _candump if path.suffix.lower() == ".log" else _python_can
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


def _python_can(path: Path, tally: Tally, position: Position) -> Iterator[Received]:
    messages = Messages(path, tally)
    first = int(path.suffix.lower() == ".trc")
    for message in messages:
        if messages.count % 1000 == 0:
            position(messages.tell())
        if message.is_remote_frame or len(message.data) == message.dlc:
            yield received_of(message, message.timestamp, _channel(message, first))
        else:
            tally.skip("shortened frame")


def _channel(message: can.Message, first: int) -> str:
    """A channel's name; formats that number their channels count from `first`."""
    if isinstance(message.channel, str) and not message.channel.isdigit():
        return message.channel
    return f"can{max(int(message.channel or 0) - first, 0)}"
