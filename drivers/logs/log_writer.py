"""Frames into a log of another format: by python-can's writers, candump text and MF4 by our own.

Times come back from every format to the microsecond. `.log`, `.blf` and `.mf4` hold all that a frame has; only that a
`.blf` counts stamps before 1990 from its first frame. `.asc` holds of an error frame only that there was one, and its
clock is local time without a zone. `.trc` holds data frames only.
"""

from collections import Counter
from contextlib import suppress
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from drivers.canbus import can
from drivers.logs.candump_line import line_of
from drivers.received import Received
from estimator.errors import SetupError, nearest

_WRITERS = {
    ".asc": "can:ASCWriter",
    ".blf": "can:BLFWriter",
    ".log": "drivers.logs.log_writer:_Candump",
    ".mf4": "drivers.logs.mf4_writer:Mf4Writer",
    ".trc": "can:TRCWriter",
}


class LogWriter:
    """A log that takes the place of `path` when it is whole; until then, and if it never is, `path` stays as it was.

    frames    written so far
    left_out  frames that the format cannot hold, by kind
    early     frames stamped before the first one: only candump text goes back in time, elsewhere they get its stamp
    """

    def __init__(self, path: Path) -> None:
        self.frames = self.early = 0
        self.left_out: Counter[str] = Counter()
        self._path, self._draft = path, path.with_name(f".{path.name}.part")
        self._suffix = check_format(path)
        self._first_s = -1.0
        module, name = _WRITERS[self._suffix].split(":")
        self._writer: Any = getattr(import_module(module), name)(self._draft)

    def write(self, frame: Received) -> None:
        """Append one frame."""
        if frame.kind != "data" and self._suffix == ".trc":
            self.left_out[frame.kind] += 1
            return
        if self._first_s < 0:
            self._begin(frame)
        if frame.time_s < self._first_s and self._suffix != ".log":
            self.early += 1
            frame = frame._replace(time_s=self._first_s)
        self._writer.on_message_received(frame if self._suffix == ".log" else _message(frame))
        self.frames += 1

    def __enter__(self) -> "LogWriter":
        return self

    def __exit__(self, kind: type[BaseException] | None, *raised: object) -> None:
        try:
            if kind is None:
                self._writer.stop()
                self._draft.replace(self._path)
            else:
                with suppress(Exception):  # what went wrong is told already
                    self._writer.stop()
        finally:
            self._draft.unlink(missing_ok=True)

    def _begin(self, frame: Received) -> None:
        self._first_s = frame.time_s
        if self._suffix == ".asc":
            # python-can writes 5 ms after a second as .5 into the head: the file has to start at a whole second
            self._writer.log_event("Start of measurement", float(int(frame.time_s)))
        if self._suffix == ".trc":
            self._writer.filepath = str(self._path.resolve())  # not the draft's


def check_format(path: Path) -> str:
    """The suffix of a format that can be written; another is a SetupError."""
    suffix = path.suffix.lower()
    if suffix not in _WRITERS:
        raise SetupError(f"{path}: cannot write '{suffix}'; {nearest(suffix, _WRITERS)}")
    if suffix == ".mf4" and find_spec("asammdf") is None:
        raise SetupError(f"{path}: writing MF4 needs asammdf: pip install 'ballscrew[mf4]'")
    return suffix


class _Candump:
    """Candump text with the details of error frames and the length of remote ones, which python-can's writer drops."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("w", encoding="ascii", errors="replace", newline="\n")
        self.stop = self._file.close

    def on_message_received(self, frame: Received) -> None:
        self._file.write(line_of(frame))


def _message(frame: Received) -> can.Message:
    remote = frame.kind == "remote"
    return can.Message(
        timestamp=frame.time_s,
        arbitration_id=frame.id,
        is_extended_id=frame.extended,
        is_remote_frame=remote,
        is_error_frame=frame.kind == "error",
        is_fd=frame.kind == "fd",
        bitrate_switch=bool(frame.flags & 1),
        error_state_indicator=bool(frame.flags & 2),
        dlc=frame.dlc if remote else len(frame.data),
        data=None if remote else frame.data,
        channel=frame.channel,
    )
