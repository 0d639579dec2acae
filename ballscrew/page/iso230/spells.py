"""When an axis is heated by repeated traverses, and when it cools at rest."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from estimator.inputs.phase import phases
from estimator.record import Recording

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
