"""An MF4 of decoded signals into the rows of a lab CSV: each signal by its name, at its own times."""

import mmap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from drivers.budget import Budget
from drivers.frames import Array, Tally
from drivers.lab.columns import Columns, some, to_the_unit
from drivers.lab.lab import Table, ticks_of
from drivers.lab.sheet import Sheet, place_of
from drivers.units import unit_of
from estimator.errors import InputError
from estimator.record import Recording
from estimator.rig import Rig

_FRAMES = b"CAN_DataFrame"  # the group of a bus that was logged


def is_decoded(path: Path) -> bool:
    """Whether a sound MF4 holds signals and no frames: names in it are never compressed."""
    if path.suffix.lower() != ".mf4" or not path.stat().st_size:
        return False
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        return content[64:68] == b"##HD" and content.find(_FRAMES) < 0


def read_signals(path: Path, rig: Rig, tally: Tally, budget: Budget) -> Recording:
    """The signals that the rig file names, as ticks; an MF4 without any of a channel is an InputError."""
    return ticks_of(SignalTable(path, rig, tally), budget)


class SignalTable(Table):
    """As a lab CSV's, a row at each time of any signal: a cell is NaN where its signal has no value then."""

    def __init__(self, path: Path, rig: Rig, tally: Tally) -> None:
        self.path, self.rig, self.tally = path, rig, tally
        self.never = {}
        signals = {**rig.channels, **rig.inputs}
        found, sheet = _signals(path, {name: rule.column or name for name, rule in signals.items()})
        if not any(name in rig.channels for name in found):
            wanted = some([rule.column or name for name, rule in rig.channels.items()])
            raise InputError(f"{path}: no signal of any channel; expected {wanted}, found {some(sheet.names)}")
        if missing := [rule.column or name for name, rule in signals.items() if name not in found]:
            tally.note(f"no signal {some(missing)}: not measured")
        units = {k: unit for k, one in enumerate(found.values()) if (unit := unit_of(one.unit))}
        columns = Columns({name: k for k, name in enumerate(found)}, (), units)
        sheet = Sheet(path, ",", [one.name for one in found.values()], [], [], ["signals by their names", *sheet.said])
        self.time = np.unique(np.concatenate([one.timestamps for one in found.values()]))
        self.line = np.arange(1, len(self.time) + 1, dtype=np.uint32)
        self.columns = {
            name: to_the_unit(self._at_all_times(one), sheet, columns, name, signals[name])
            for name, one in found.items()
        }
        self.said, self.units = sheet.said, {}

    def _at_all_times(self, signal: Any) -> Array:
        values = np.full(len(self.time), np.nan)
        values[np.searchsorted(self.time, signal.timestamps)] = signal.samples
        return values


def every_signal(path: Path) -> dict[str, Any]:
    """All signals of an MF4 by name, as asammdf has them, the first of a name; None where one holds no numbers."""
    with _opened(path) as (mdf, places):
        first = dict(reversed(places))
        return {name: _numbers(mdf, *first[name]) for name in reversed(first)}


def _signals(path: Path, names: dict[str, str]) -> tuple[dict[str, Any], Sheet]:
    """What an MF4 has of these channels and inputs, and all names in it."""
    with _opened(path) as (mdf, places):
        sheet = Sheet(path, ",", [name for name, _ in places], [], [], [])
        taken = {k for k, name in enumerate(sheet.names) if name in names.values()}
        of = {name: place_of(sheet, wanted, taken) for name, wanted in names.items()}
        found = {name: _numbers(mdf, *places[k][1]) for name, k in of.items() if k is not None}
    return {name: one for name, one in found.items() if one is not None}, sheet


@contextmanager
def _opened(path: Path) -> Iterator[tuple[Any, list[tuple[str, tuple[int, int]]]]]:
    """An MF4, with name, group and index of each of its signals but times; one that is broken is an InputError."""
    from asammdf import MDF  # a second

    try:
        with path.open("rb") as file, MDF(file) as mdf:
            every = [(k, n) for k in range(len(mdf.groups)) for n in range(len(mdf.groups[k].channels))]
            places = [(group, k) for group, k in every if k != mdf.masters_db.get(group)]
            yield mdf, [(mdf.groups[group].channels[k].name, (group, k)) for group, k in places]
    except InputError:
        raise
    except Exception as error:  # whatever asammdf raises on a broken file
        why = f"{type(error).__name__}: {' '.join(str(error).split())[:120]}"
        raise InputError(f"{path}: cannot be read as MF4: {why}") from None


def _numbers(mdf: Any, group: int, index: int) -> Any:
    """A signal with those of its samples that are valid; None where there are none, or no numbers."""
    signal = mdf.get(group=group, index=index).validate()
    numbers = signal.samples.ndim == 1 and signal.samples.dtype.kind in "fiub" and len(signal.timestamps)
    return signal if numbers else None
