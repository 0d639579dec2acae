"""Logs of CAN frames by suffix; the reader is imported when a file asks for it."""

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from drivers.budget import Budget
from drivers.foreign import begins_as, way_out
from drivers.frames import Frames, Tally, plausible
from drivers.lab.frame_table import PYTHON_CAN, frame_names
from drivers.lab.sheet import encoding_of
from drivers.lab.signals import is_decoded
from estimator.errors import InputError, nearest

# What a file of each suffix must be, and what reads it.
_READERS = {
    ".log": ("drivers.logs.candump:read_candump", 'candump text like "(1699999999.123456) can0 210#0011223344556677"'),
    ".asc": ("drivers.logs.outside:read_outside", "a Vector ASC log; a table as text is read as .csv: rename it"),
    ".blf": ("drivers.logs.outside:read_outside", "a Vector BLF log"),
    ".trc": ("drivers.logs.outside:read_outside", "a PEAK TRC log"),
    ".mf4": ("drivers.logs.outside:read_outside", "an ASAM MDF 4 file with frames of a CAN bus"),
    ".csv": ("drivers.logs.outside:read_outside", "python-can's CSV of frames"),
}
SUFFIXES = frozenset(_READERS)
_PLAIN = {".log", ".asc", ".trc"}
_TEXT = {*_PLAIN, ".csv"}
_TABLE = "drivers.lab.frame_table:read_frame_table", "a CSV of frames by SavvyCAN or a CANedge"


def regular(path: Path) -> Path:
    """The path itself; what is no readable regular file with a known suffix is an InputError."""
    if path.suffix.lower() not in _READERS:
        fix = way_out(path.suffix) or nearest(path.suffix.lower(), _READERS)
        raise InputError(f"{path}: no known kind of log '{path.suffix}'; {fix}")
    try:
        if not path.is_file():
            raise InputError(f"{path}: {'not a regular file' if path.exists() else 'no such file'}")
        other = begins_as(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if other and path.suffix.lower() in _TEXT:
        raise InputError(f"{path}: {other}")
    if path.suffix.lower() in _PLAIN and encoding_of(path).startswith("utf-16"):
        raise InputError(f"{path}: is UTF-16 text; convert it: iconv -f UTF-16 -t UTF-8 {path.name} > NEW{path.suffix}")
    if path.suffix.lower() == ".mf4" and find_spec("asammdf") is None:
        raise InputError(f"{path}: reading MF4 needs asammdf: pip install 'ballscrew[mf4]'")
    return path


def is_lab_csv(path: Path) -> bool:
    """Whether the file is a lab CSV, and not one of frames."""
    return regular(path).suffix.lower() == ".csv" and frame_names(path) is None


def is_frame_table(path: Path) -> bool:
    """Whether the file is a CSV of frames by another program than python-can."""
    found = frame_names(path) if regular(path).suffix.lower() == ".csv" else None
    return found is not None and found[2][:2] != PYTHON_CAN


def read_log(path: Path, tally: Tally, budget: Budget, progress: Callable[[float], None] | None = None) -> Frames:
    """All usable frames of a log; none at all is an InputError that says what was found and expected."""
    if is_decoded(path):
        raise InputError(
            f"{path}: holds decoded signals, no frames; what needs none, such as review, reads them by names"
        )
    reader, expected = _TABLE if is_frame_table(path) else _READERS[path.suffix.lower()]
    module, function = reader.split(":")
    frames, found = getattr(import_module(module), function)(path, tally, budget, progress)
    frames = plausible(frames, tally)
    if not len(frames):
        why = "; ".join([*(f"{count} x {reason}" for reason, count in tally.skipped.items()), *tally.notes])
        raise InputError(f"{path}: 0 usable frames ({found}{'; ' if why else ''}{why}); expected {expected}")
    return frames
