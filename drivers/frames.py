"""Frames of a log as arrays, and the account of everything that was not used."""

import struct
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.intp]
Mask = NDArray[np.bool_]
Whole = NDArray[np.int64]
# One frame as 27 bytes: what a reader in another process sends, and what arrays are cut from.
FRAME = np.dtype(
    [
        ("time", "<f8"),
        ("id", "<u4"),
        ("extended", "?"),
        ("dlc", "u1"),
        ("data", "u1", (8,)),
        ("number", "<u4"),
        ("bus", "u1"),
    ]
)
_COLUMNS = FRAME.names or ()
PACKED = struct.Struct("<dI?B8sIB")  # the same for one frame


@dataclass
class Tally:
    """What was skipped, by reason, and sentences that say where: filled by every stage from the file to the ticks.

    refused  readings of each channel or input that came and are none;   of_readings  the reasons that count such
    doubts   those of the notes that change how figures are read: they come first
    """

    skipped: Counter[str] = field(default_factory=Counter)
    notes: list[str] = field(default_factory=list)
    refused: Counter[str] = field(default_factory=Counter)
    of_readings: set[str] = field(default_factory=set)
    doubts: set[str] = field(default_factory=set)

    def skip(self, reason: str, count: int | np.integer[Any] = 1) -> None:
        """Count `count` things that were not used. A hostile log invents reasons: past 300 they are lumped."""
        if count:
            self.skipped[reason if reason in self.skipped or len(self.skipped) < 300 else "other reasons"] += int(count)

    def refuse(self, reason: str, name: str, count: int | np.integer[Any]) -> None:
        """Count readings of a channel or input that are none; the frames that brought them are well."""
        if count:
            self.of_readings.add(f"{reason} {name}")
            self.skip(f"{reason} {name}", count)
            self.refused[name] += int(count)

    def counts(self) -> dict[str, int]:
        """How many of each reason."""
        return {reason: count for reason, count in self.skipped.items() if count > 0}

    def note(self, sentence: str) -> None:
        """Keep a sentence once; past 50 of them only their number grows."""
        if sentence in self.notes:
            return
        if len(self.notes) < 50:
            self.notes.append(sentence)
        else:
            self.skip("further notes")

    def doubt(self, sentence: str) -> None:
        """Keep a sentence that changes how figures are read, before all that do not."""
        self.doubts.add(sentence)
        self.first(sentence)

    def first(self, sentence: str) -> None:
        """Keep a sentence before all but doubts."""
        if sentence not in self.notes:
            self.notes.insert(len(self.doubts.intersection(self.notes)), sentence)


@dataclass(frozen=True)
class Frames:
    """Classic CAN data frames in the order of the log.

    time      (n,) s, the log's own clock
    id        (n,) uint32 without flag bits
    extended  (n,) bool: 29-bit id
    dlc       (n,) uint8, 0 ... 8
    data      (n, 8) uint8, zero beyond dlc
    number    (n,) of the line in a text log, else of the frame, from 1
    bus       (n,) uint8, which of `buses`
    unit      "line" or "frame": what `number` counts
    buses     names of the buses that were recorded: "can0", or "can0 = channel 1" where the log numbers them
    """

    time: Array
    id: NDArray[np.uint32]
    extended: Mask
    dlc: NDArray[np.uint8]
    data: NDArray[np.uint8]
    number: NDArray[np.uint32]
    bus: NDArray[np.uint8]
    unit: str = "frame"
    buses: tuple[str, ...] = ("can0",)

    def __len__(self) -> int:
        return len(self.time)

    @cached_property
    def key(self) -> Whole:
        """Id and kind in one number, (n,)."""
        return self.id.astype(np.int64) << 1 | self.extended

    def take(self, which: Mask | Index | slice) -> "Frames":
        """The frames at these indices, or where a mask is true; if that is all of them, themselves and no copy."""
        if not isinstance(which, slice) and len(which) == len(self) and _is_all(which):
            return self
        columns = {name: getattr(self, name)[which] for name in _COLUMNS}
        return Frames(**columns, unit=self.unit, buses=self.buses)

    def on_clock(self, time: Array) -> "Frames":
        """The same frames with other stamps, (n,) s."""
        return self if time is self.time else replace(self, time=time)

    def where(self, index: int) -> str:
        """Where one frame stands, as text: "line 1204"."""
        return f"{self.unit} {int(self.number[index])}"

    @classmethod
    def of(cls, tables: Sequence[NDArray[np.void]], unit: str, buses: Sequence[str] = ("can0",)) -> "Frames":
        """From tables of dtype FRAME, one behind the other."""
        columns = {name: np.concatenate([table[name] for table in tables]) for name in _COLUMNS}
        return cls(**columns, unit=unit, buses=tuple(buses))

    @classmethod
    def joined(cls, parts: "Sequence[Frames]") -> "Frames":
        """One log behind the other."""
        named = [[name.partition(" = ")[0] for name in part.buses] for part in parts]
        buses = tuple(dict.fromkeys(name for names in named for name in names))
        same = [
            np.array([buses.index(b) for b in names], np.uint8)[p.bus] for p, names in zip(parts, named, strict=True)
        ]
        columns = {name: np.concatenate([getattr(part, name) for part in parts]) for name in _COLUMNS[:-1]}
        return cls(**columns, bus=np.concatenate(same), unit=parts[0].unit, buses=buses)


def _is_all(which: Mask | Index) -> bool:
    """Whether a mask, or as many indices as there are frames, say each of them in order."""
    return bool(which.all() if which.dtype == bool else (which == np.arange(len(which))).all())


def words_of(data: NDArray[np.uint8]) -> tuple[NDArray[np.uint64], NDArray[np.uint64]]:
    """The eight bytes of each frame, (n, 8), as one number, (n,) little-endian and (n,) big-endian."""
    data = np.ascontiguousarray(data)
    return data.view("<u8")[:, 0], data.view(">u8")[:, 0].astype(np.uint64)


def key_of(can_id: int, extended: bool) -> int:
    """`Frames.key` of one frame."""
    return can_id << 1 | extended


def id_of(key: int) -> str:
    """The id in a `Frames.key`, as candump writes it: eight digits where it has 29 bits."""
    return f"0x{key >> 1:0{8 if key & 1 else 3}X}"


def few(names: Sequence[str], most: int = 4) -> str:
    """The first of some names in words, and how many more there are."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def falls_again_and_again(time: Array) -> bool:
    """Whether times, (n,) s, each count from the one before: they fall by much more than all of them span."""
    falls = -np.diff(time)
    return bool(len(time) and falls[falls > 0].sum() > 5 * np.ptp(time))


LATEST_S = 4.2e9  # a stamp after 2100 is none


def plausible(frames: Frames, tally: Tally) -> Frames:
    """Only frames that can have been on a bus: a finite time from 1970 to 2100, an id that fits, at most 8 bytes."""
    finite = np.isfinite(frames.time)
    span = finite & (frames.time >= 0) & (frames.time < LATEST_S)
    fits = frames.id <= np.where(frames.extended, 0x1FFFFFFF, 0x7FF)
    short = frames.dlc <= 8
    good = span & fits & short
    if good.all():
        return frames
    tally.skip("time stamp is no number", np.count_nonzero(~finite))
    tally.skip("time stamp absurd", np.count_nonzero(finite & ~span))
    tally.skip("impossible id", np.count_nonzero(span & ~fits))
    tally.skip("more than 8 bytes", np.count_nonzero(span & fits & ~short))
    return frames.take(good)
