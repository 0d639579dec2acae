"""The paper's processing of the displacement readings, for display and as a reference, never for the filter.

Readings come at the stroke centre while the table moves (peak hold), directly at rest (from the same channel where a
rig has no input of its own for it). Five corrections: the half sum
of the four probes less its value at the start; the expansion of probes and bar taken out; readings at the stroke
centre only; the half stroke before the first held value and after the last one; the direct reading at rest joined to
the stop. The half strokes look into the future, so a filter must not use them.

Beyond the paper: a rest joins at both ends by a line through the direct readings of ten seconds, not by one, whose
scatter would stay in all that follows; and the last tick before a drive is left out: the screw may have turned when it
was read.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from estimator.inputs.phase import phases
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig

EDGE_S = 10.0  # by the direct readings of so many seconds a rest joins what is before and after it


class Joined(NamedTuple):
    """Measured elongation since the start, NaN where nothing was read.

    um       (K,)
    noise    (K,) its variance over that of one reading: it grows with every half stroke, and at rest all readings are
             off together by what the join was
    scatter  sd of one reading, um
    """

    um: Array
    noise: Array
    scatter: float

    @property
    def sd(self) -> Array:
        """(K,) um, from the scatter of the readings alone."""
        return self.scatter * np.sqrt(self.noise)


class Stop(NamedTuple):
    """The elongation where a drive or a rest ends, um, of one run or (k,) of several, and its variance over that of one
    reading."""

    um: Any
    noise: float


def joined(recording: Recording, rig: Rig, model: Model) -> Joined:
    """Held values while driving, the direct reading at rest; nothing where the rig has no displacement channel."""
    um, noise = np.full((2, len(recording)), np.nan)
    if "displacement" not in rig.channels:
        return Joined(um, noise, 0.0)
    expansion = jig_expansion(recording, model)
    held = recording.channels[:, rig.index("displacement")] - expansion
    direct = recording.inputs["displacement_direct"] - expansion if "displacement_direct" in recording.inputs else held
    read_at = recording.time_s - recording.ages_s[:, rig.index("displacement")]
    scatter = model["displacement.sd"] if "displacement.sd" in model.values else 0.0
    out, end = Joined(um, noise, scatter), Stop(0.0, 0.0)
    for driving, ticks in phases(recording):
        if driving:
            end = _drive(held, read_at, recording.time_s, ticks, end, out)
        else:
            end = _rest(direct, recording.time_s, ticks, end, out)
    return out


def jig_expansion(recording: Recording, model: Model) -> Array:
    """What warm probes add to a reading and a warm bar takes away, (K,) um; 0 where they are not measured."""
    total = np.zeros(len(recording))
    for name, sign in (("probe", 1.0), ("bar", -1.0)):
        column = recording.inputs.get(name)
        if column is not None and np.isfinite(column).any() and f"displacement.{name}" in model.values:
            first = column[np.isfinite(column)][0]
            total += sign * model[f"displacement.{name}"] * np.nan_to_num(column - first)
    return total


def _drive(held: Array, read_at: Array, time_s: Array, ticks: Array, before: Stop, out: Joined) -> Stop:
    """Fill the held values of one drive; returns the level at its stop.

    The first reading comes half a stroke after the start and the stop half a stroke after the last one: the growth
    there is taken from the neighbouring stroke, in proportion to the time (half of it, when every centre was read).
    """
    read = ticks[np.isfinite(held[ticks])]
    if len(read) < 2:
        return before
    first, second, last_but_one, last = read[0], read[1], read[-2], read[-1]
    began, stopped = time_s[ticks[0] - 1] if ticks[0] else time_s[0], time_s[ticks[-1]]
    head = min((read_at[first] - began) / (read_at[second] - read_at[first]), 1.0)
    tail = min((stopped - read_at[last]) / (read_at[last] - read_at[last_but_one]), 1.0)
    start = before.um + head * (held[second] - held[first])
    zero = before.noise + (1.0 + head) ** 2 + head**2
    out.um[read], out.noise[read] = held[read] - held[first] + start, zero + 1.0
    stop = out.um[last] + tail * (held[last] - held[last_but_one])
    return Stop(float(stop), float(zero + (1.0 + tail) ** 2 + tail**2))


def _rest(direct: Array, time_s: Array, ticks: Array, before: Stop, out: Joined) -> Stop:
    """Fill one rest with the direct reading shifted to join the level at the stop; returns its last level."""
    if ticks[-1] + 1 < len(time_s):
        ticks = ticks[:-1]
    read = ticks[np.isfinite(direct[ticks])]
    if not len(read):
        return before
    first = level(time_s[read], direct[read], time_s[ticks[0] - 1] if ticks[0] else time_s[read[0]])
    zero = before.noise + first.noise
    out.um[read], out.noise[read] = direct[read] - first.um + before.um, zero + 1.0
    last = level(time_s[read], out.um[read], time_s[ticks[-1]])
    return Stop(last.um, zero + last.noise)


def level(time_s: Array, reading: Array, at_s: float, edge_s: float = EDGE_S) -> Stop:
    """Where a line through the readings near a time is at that time; the nearest reading if there are few.

    time_s (K,);   reading (K,), or (K, k) of k at the same times
    """
    apart = time_s - at_s
    near = np.abs(apart) <= edge_s
    if near.sum() < 3:
        return Stop(reading[np.abs(apart).argmin()], 1.0)
    middle = apart[near].mean()
    off = apart[near] - middle
    slope, spread = off @ reading[near] / (off @ off), middle**2 / (off @ off)
    return Stop(reading[near].mean(axis=0) - slope * middle, float(1.0 / near.sum() + spread))
