"""CAN frames as a CSV: of SavvyCAN (GVRET) and of a CANedge. A lab CSV holds none, whatever its columns are called.

SavvyCAN, us, ms or s:  Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8
CANedge, seconds:       TimestampEpoch;BusChannel;ID;IDE;DLC;DataLength;Dir;EDL;BRS;DataBytes
"""

import csv
import re
from collections.abc import Callable, Mapping, Sequence
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drivers.budget import Budget
from drivers.frames import FRAME, LATEST_S, PACKED, Array, Frames, Tally
from drivers.lab.counting import SECONDS, WORDS
from drivers.lab.names import bare
from drivers.lab.sheet import SEPARATORS, encoding_of, whole_lines
from estimator.errors import InputError

_HEAD = 30  # lines among which the names are
_IDS = {"id", "canid", "arbitrationid", "identifier", "msgid", "messageid", "frameid"}
_DATA = re.compile(r"data(bytes?|hex)?\d*|[db]\d|byte\d")
_ABOUT = {
    "format", "flags", "dlc", "len", "length", "datalength", "ide", "extended", "ext", "bus", "buschannel", "chn",
    "dir", "type",
}  # fmt: skip
PYTHON_CAN = ["timestamp", "arbitrationid"]
_SHORTEST_US = 40.0  # from frame to frame on a bus of 1 Mbit/s
_SILENT_S = 1.5  # more than nineteen in twenty frames of a bus come after
_SAVVY, _EDGE = {"timestamp", "id", "extended", "len"}, {"timestampepoch", "id", "databytes"}


def frame_names(path: Path) -> tuple[int, str, list[str]] | None:
    """Where the names of a CSV of frames stand: line, separator and names as they are meant; None for another CSV."""
    with path.open(encoding=encoding_of(path), errors="replace", newline="") as file:
        head = list(islice(file, _HEAD))
    for at, line in enumerate(head):
        for separator in list(SEPARATORS)[:3]:
            names = [bare(cell) for cell in next(csv.reader([line[:4096]], delimiter=separator), [])]
            if {*names} & _IDS and any(map(_DATA.fullmatch, names)) and {*names} & _ABOUT:
                return at, separator, names
    return None


def read_frame_table(
    path: Path, tally: Tally, budget: Budget, progress: Callable[[float], None] | None = None
) -> tuple[Frames, str]:
    """All data frames of a CSV of frames, and what was found, in words; of another program's it is an InputError."""
    found = frame_names(path)
    assert found
    at, separator, names = found
    if not any(kind.issubset(names) for kind in (_SAVVY, _EDGE)):
        what = ", ".join(names[:6])
        raise InputError(
            f"{path}: frames in a CSV of another kind ({what} ...) than SavvyCAN's, CANedge's or python-can's: "
            "export or convert them to .asc, .blf or candump's .log"
        )
    column = {name: k for k, name in enumerate(names)}
    with path.open(encoding=encoding_of(path), errors="replace", newline="") as file:
        lines = islice(whole_lines(file, tally, budget), at + 1, None)
        rows = csv.reader(lines, delimiter=separator)
        take = _edge if "timestampepoch" in column else _savvy
        packed, buses = [], dict[str, int]()
        for row in islice(rows, budget.frames):
            if frame := _frame(row, column, take, tally):
                time_s, can_id, extended, data, bus = frame
                number = buses.setdefault(bus, len(buses))
                line = rows.line_num + at + 1
                packed.append(PACKED.pack(time_s, can_id, extended, len(data), data, line, min(number, 255)))
    table = np.frombuffer(b"".join(packed), FRAME).copy()
    if take is _savvy:
        table["time"] *= _count_s(table["time"], table["bus"], tally)
    return Frames.of([table], "line", tuple(buses) or ("can0",)), f"{len(packed)} lines with frames"


def _count_s(time: Array, bus: NDArray[np.uint8], tally: Tally) -> float:
    """What one count of SavvyCAN's stamps, (n,), is, s: a bus takes 50 us for a frame and is not silent for seconds."""
    time = time[np.isfinite(time) & (bus == np.bincount(bus, minlength=1).argmax())]
    if len(time) < 2:
        return SECONDS["us"]
    steps, whole = np.abs(np.diff(time)), bool((time % 1 == 0).all())
    if whole and time.max() > LATEST_S * 1e6:
        unit = "ns"
    elif whole:
        unit = "ms" if np.quantile(steps, 0.25) < _SHORTEST_US else "us"
    else:
        unit = "ms" if np.quantile(steps, 0.95) > _SILENT_S else "s"
    if unit in ("ns", "ms"):
        tally.note(f"its times count {WORDS[unit]}")
    return SECONDS[unit]


Frame = tuple[float, int, bool, bytes, str]
Take = Callable[[Sequence[str], Mapping[str, int]], Frame]


def _frame(row: list[str], column: Mapping[str, int], take: Take, tally: Tally) -> Frame | None:
    if not any(map(str.strip, row)):
        return None
    try:
        if "edl" in column and row[column["edl"]].strip() == "1":
            tally.skip("CAN FD frame")
            return None
        frame = take(row, column)
        if len(frame[3]) <= 8:
            return frame
        tally.skip("CAN FD frame")
    except (ValueError, IndexError):
        tally.skip("torn or foreign line")
    return None


def _savvy(row: Sequence[str], column: Mapping[str, int]) -> Frame:
    first, size = column.get("d1", column.get("d0", len(row))), int(row[column["len"]])
    data = bytes(int(cell, 16) for cell in row[first : first + size])
    if len(data) < size:
        raise ValueError
    time = float(row[column["timestamp"]].replace(",", "."))
    bus = f"can{int(row[column['bus']])}" if "bus" in column else "can0"
    return time, int(row[column["id"]], 16), row[column["extended"]].strip().lower() in ("true", "1"), data, bus


def _edge(row: Sequence[str], column: Mapping[str, int]) -> Frame:
    can_id, data = int(row[column["id"]], 16), bytes.fromhex(row[column["databytes"]])
    extended = row[column["ide"]].strip() == "1" if "ide" in column else can_id > 0x7FF
    bus = f"can{int(row[column['buschannel']]) - 1}" if "buschannel" in column else "can0"
    return float(row[column["timestampepoch"]].replace(",", ".")), can_id, extended, data, bus
