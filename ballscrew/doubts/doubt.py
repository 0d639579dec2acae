"""A doubt about a rig folder, and what each kind of doubt is told of."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ballscrew.new_rig.bus_log import BusLog
from ballscrew.new_rig.lab_table import LabTable
from ballscrew.new_rig.seen import Seen
from drivers.frames import Array
from drivers.lab.names import known_as
from estimator.model import Model
from estimator.record import Recording
from estimator.rig import Rig, Signal


class Doubt(NamedTuple):
    """One line: the place in the folder, what looks wrong there, what to do about it."""

    place: str
    doubt: str
    fix: str


@dataclass(frozen=True)
class Case:
    """A rig folder beside one of its recordings: as it reads there, and signal by signal as it is in the file."""

    rig: Rig
    model: Model
    recording: Recording
    source: BusLog | LabTable

    @cached_property
    def seen(self) -> dict[str, Seen]:
        """Every signal of the file, by "Message.Signal" or column."""
        return {one.source: one for one in self.source.seen}

    def signals(self) -> Iterable[tuple[str, str, Signal]]:
        """Table, name and entry of each channel and input."""
        yield from (("channels", name, rule) for name, rule in self.rig.channels.items())
        yield from (("inputs", name, rule) for name, rule in self.rig.inputs.items())

    def of(self, name: str, rule: Signal) -> list[Seen]:
        """What of the file an entry of rig.toml reads."""
        if isinstance(self.source, BusLog):
            return [self.seen[one] for one in rule.signals if one in self.seen]
        column = rule.column or name
        near = [one for other, one in self.seen.items() if known_as(other, column)]
        return [self.seen[column]] if column in self.seen else near[:1]

    def place(self, table: str, name: str) -> str:
        """Where an entry stands."""
        return f"rig.toml: {table}.{name}"

    @cached_property
    def rises(self) -> Array:
        """Rise of each thermometer on the screw since its first reading, (ticks, n), in the order of their places."""
        names = self.on_the_screw
        columns = self.recording.channels[:, [self.rig.index(name) for name in names]]
        known = np.isfinite(columns)
        first = columns[known.argmax(axis=0), np.arange(len(names))]
        return columns - first

    @cached_property
    def on_the_screw(self) -> list[str]:
        """The thermometers there, by place."""
        places = {name: one.at_mm for name, one in self.rig.channels.items() if one.at_mm is not None}
        return sorted(places, key=lambda name: places[name])

    @cached_property
    def warmth(self) -> Array:
        """The mean rise of the thermometers, (ticks,) K; NaN where none reads."""
        read = np.isfinite(self.rises).any(axis=1) if self.rises.size else np.zeros(len(self.recording), bool)
        mean = np.full(len(self.recording), np.nan)
        mean[read] = np.nanmean(self.rises[read], axis=1)
        return mean
