"""Readings into ticks: the same few lines for a whole log, for a live tick and for a lab CSV."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from drivers.decode.drive import Drive, DriveCondenser
from drivers.frames import Array, Index, Mask, Tally, Whole
from estimator.record import Recording
from estimator.rig import RAD_S, Rig

AT_ONCE = 2048  # ticks


class Readings(NamedTuple):
    """Of one channel or input, in order: frame number in the log (n,), tick (n,), time (n,) s, value (n,)."""

    frame: Whole
    row: Index
    now: Array
    value: Array

    def where(self, use: Mask | slice) -> "Readings":
        """Those in a slice, or for which `use` (n,) is true."""
        return Readings._make(column[use] for column in self)

    def of_ticks(self, ticks: slice) -> "Readings":
        """Those of some ticks, counted from the first of them."""
        some = self.where(slice(*np.searchsorted(self.row, [ticks.start, ticks.stop])))
        return some._replace(row=some.row - ticks.start)

    def after(self, other: "Readings") -> "Readings":
        """These behind the others."""
        return Readings._make(map(np.concatenate, zip(other, self, strict=True)))


def portions(ticks: int) -> list[slice]:
    """Ticks that are worked out at a time."""
    return [slice(k, min(k + AT_ONCE, ticks)) for k in range(0, ticks, AT_ONCE)]


NONE = Readings(np.empty(0, np.int64), np.empty(0, np.intp), np.empty(0), np.empty(0))


class Condenser:
    """Turns readings into rows; carries what the drive did last from call to call."""

    def __init__(self, rig: Rig, tally: Tally, held_ticks: int = 2) -> None:
        self.rig = rig
        self.drive = DriveCondenser(rig, tally, held_ticks)
        self.rad_s = RAD_S[rig.inputs["speed"].unit] if "speed" in rig.inputs else 1.0
        self._position = NONE

    def rows(self, readings: Mapping[str, Readings], date: Array) -> Recording:
        """One row per tick; `date` (rows,) is when each closed. The record has no name and no account yet."""
        rows, names = len(date), self.rig.names
        channels, ages = np.full((rows, len(names)), np.nan), np.zeros((rows, len(names)))
        for column, name in enumerate(names):
            reading = readings.get(name, NONE)
            # of several readings in a tick the last is kept: later assignments win
            channels[reading.row, column] = reading.value
            ages[reading.row, column] = np.maximum(date[reading.row] - reading.now, 0.0)
        inputs = {}
        for name in self.rig.inputs:
            inputs[name] = np.full(rows, np.nan)
            inputs[name][readings.get(name, NONE).row] = readings.get(name, NONE).value
        drive = self._drive(readings.get("position", NONE), readings.get("speed", NONE), rows)
        return Recording("", date, channels, ages, inputs, **drive._asdict())

    def whole(self, readings: Mapping[str, Readings], date: Array) -> Recording:
        """The same of a whole log, some ticks at a time: the nut's cover of all cells would fill the memory."""
        parts = []
        for at in portions(len(date)):
            some = {name: reading.of_ticks(at) for name, reading in readings.items()}
            parts.append(self.rows(some, date[at]).packed())
        return Recording.joined(parts)

    def _drive(self, position: Readings, speed: Readings, rows: int) -> Drive:
        position = position.after(self._position)
        self._position = position._replace(row=position.row - rows).where(slice(-1, None))
        return self.drive.rows(speed.now, _at(position, speed), speed.value * self.rad_s, speed.row, rows)


def _at(position: Readings, speed: Readings) -> Array:
    """The position known at each speed, (n,) mm: of the same or an earlier frame, at most a tick ago, else NaN."""
    if not len(position.row):
        return np.full(len(speed.row), np.nan)
    index = np.searchsorted(position.frame, speed.frame, side="right") - 1
    fresh = (index >= 0) & (speed.row - position.row[index] <= 1)
    return np.where(fresh, position.value[index], np.nan)
