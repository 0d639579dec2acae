"""The drift of a linear axis at fixed positions, while it is driven and while it cools: after ISO 230-3, the test of
thermal distortion caused by moving linear axes, with an estimate in the place of gauges.

whole = growth between the anchor bearing and the nut's centre since the start
left  = whole - what the filter has published a tick before: what a control leaves that adds its negative

The truth where the recording has one beside it; else the estimate, so that `left` is what it changes by in a tick and
its own uncertainty comes on top.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from drivers.logs.truth import Truth
from estimator.accuracy.review import Review
from estimator.inputs.phase import phases
from estimator.record import Array, Recording

HOUR_S = 3600.0
PAUSE_S = 300.0  # a shorter rest between drives is part of the heating: gauges are read in such


@dataclass(frozen=True)
class Spell:
    """A heating, repeated traverses, or a cooling, at rest; from the tick before its first to its last."""

    heats: bool
    number: int
    first: int
    last: int

    @property
    def name(self) -> str:
        """As a table has it."""
        return f"{'heating' if self.heats else 'cooling'} {self.number}"


@dataclass(frozen=True)
class Drift:
    """One recording's drift at p positions; (K, p) um each.

    true  whether it is the truth; else sd_um is that of both
    """

    recording: Recording
    at_mm: Array
    whole_um: Array
    left_um: Array
    sd_um: Array
    true: bool
    spells: Sequence[Spell]

    def place(self, i: int) -> str:
        """One of its positions."""
        return f"P{i + 1} at {self.at_mm[i]:g} mm"

    def ranges(self, spell: Spell) -> "list[Range]":
        """What a spell comes to at each position."""
        return [self._range(spell, i) for i in range(len(self.at_mm))]

    def _range(self, spell: Spell, i: int) -> "Range":
        time_s, ticks = self.recording.time_s, np.arange(spell.first, spell.last + 1)
        hour = ticks[time_s[ticks] <= time_s[spell.first] + HOUR_S]
        whole, left, sd = (each[:, i] for each in (self.whole_um, self.left_um, self.sd_um))
        ends = left - 2 * sd, left + 2 * sd
        return Range(
            float(self.at_mm[i]), width(whole[hour]), width(whole[ticks]), last(whole[ticks]),
            2 * highest(sd[ticks]), width(*(end[hour] for end in ends)), width(*(end[ticks] for end in ends)),
            last(left[ticks]) if self.true else float("nan"),
        )  # fmt: skip


@dataclass(frozen=True)
class Range:
    """What one spell comes to at one position, um; `left`: with compensation, two sd of an estimate counted in.

    first_hour_um, whole_um  highest minus lowest in its first 60 min, and in all of it
    end_um                   at its end; of an estimate nothing is known to be left there but its sd: NaN
    two_sd_um                by how much these may be off
    """

    at_mm: float
    first_hour_um: float
    whole_um: float
    end_um: float
    two_sd_um: float
    left_first_hour_um: float
    left_whole_um: float
    left_end_um: float


def width(low: Array, high: Array | None = None) -> float:
    """Highest minus lowest of what is known; NaN of nothing."""
    high = low if high is None else high
    return float(np.nanmax(high) - np.nanmin(low)) if np.isfinite(low).any() else float("nan")


def last(values: Array) -> float:
    """The last that is known."""
    known = values[np.isfinite(values)]
    return float(known[-1]) if len(known) else float("nan")


def highest(values: Array) -> float:
    """The highest that is known."""
    return float(np.nanmax(values)) if np.isfinite(values).any() else float("nan")


def drift(review: Review, truth: Truth | None, at_mm: Sequence[float]) -> Drift:
    """What one recording's review tells at these positions of the table."""
    recording, table = review.recording, review.table.at(at_mm)
    true = np.full_like(table.error_um, np.nan) if truth is None else truth.at_table(table.at_mm, recording.time_s)
    known = bool(np.isfinite(true).any(axis=0).all())
    began = np.nan_to_num(table.error_um[int(np.flatnonzero(review.track.begins)[-1])])
    whole = true + began if known else table.error_um
    published = np.vstack([np.full((1, len(at_mm)), np.nan), table.error_um[:-1]])
    sd = np.zeros_like(table.sd_um) if known else table.sd_um
    return Drift(recording, table.at_mm, whole, whole - published, sd, known, spells(recording))


def spells(recording: Recording) -> list[Spell]:
    """Heatings and coolings in order, from the first drive on."""
    found: list[Spell] = []
    for heats, first, last_tick in _merged(recording):
        if found and found[-1].heats == heats:
            found[-1] = Spell(heats, found[-1].number, found[-1].first, last_tick)
        elif heats or found:
            number = sum(one.heats for one in found) + heats
            found.append(Spell(heats, number, max(first - 1, 0), last_tick))
    return found


def _merged(recording: Recording) -> Iterator[tuple[bool, int, int]]:
    """Drives and rests, short rests between two drives as drives."""
    driven = False
    for driving, ticks in phases(recording):
        first, last_tick = int(ticks[0]), int(ticks[-1])
        pause = recording.time_s[last_tick] - recording.time_s[first] < PAUSE_S and last_tick + 1 < len(recording)
        yield driving or (driven and bool(pause)), first, last_tick
        driven = driven or driving
