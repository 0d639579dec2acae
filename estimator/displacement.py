"""The paper's processing of the displacement readings, for display and as a reference, never for the filter.

Readings come at the stroke centre while the table moves (peak hold), directly at rest (from the same channel where a
rig has no input of its own for it). Five corrections: the half sum
of the four probes less its value at the start; the expansion of probes and bar taken out; readings at the stroke
centre only; the half stroke before the first held value and after the last one; the direct reading at rest joined to
the stop. The half strokes look into the future, so a filter must not use them.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from estimator.model import Model
from estimator.record import Array, Recording
from estimator.regime import AT_REST
from estimator.rig import Rig


def joined(recording: Recording, rig: Rig, model: Model) -> Array:
    """Measured elongation since the start, (K,) um: held values while driving, the direct reading at rest, else NaN."""
    expansion = jig_expansion(recording, model)
    held = recording.channels[:, rig.index("displacement")] - expansion
    direct = recording.inputs["displacement_direct"] - expansion if "displacement_direct" in recording.inputs else held
    read_at = recording.time_s - recording.ages_s[:, rig.index("displacement")]
    out, value = np.full(len(recording), np.nan), 0.0
    for driving, ticks in phases(recording):
        if driving:
            value = _drive(held, read_at, recording.time_s, ticks, value, out)
        else:
            value = _rest(direct, ticks, value, out)
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


def phases(recording: Recording) -> Iterator[tuple[bool, Array]]:
    """Drives and rests in order, as (driving, indices of the ticks)."""
    driving = np.nan_to_num(recording.omega) > AT_REST
    borders = np.flatnonzero(np.diff(driving)) + 1
    for ticks in np.split(np.arange(len(recording)), borders):
        yield bool(driving[ticks[0]]), ticks


def _drive(held: Array, read_at: Array, time_s: Array, ticks: Array, before: float, out: Array) -> float:
    """Fill the held values of one drive; returns the value at its stop.

    The first reading comes half a stroke after the start and the stop half a stroke after the last one: the growth
    there is taken from the neighbouring stroke, in proportion to the time (half of it, when every centre was read).
    """
    read = ticks[np.isfinite(held[ticks])]
    if len(read) < 2:
        return before
    first, second, last_but_one, last = read[0], read[1], read[-2], read[-1]
    began, stopped = time_s[ticks[0] - 1] if ticks[0] else time_s[0], time_s[ticks[-1]]
    head = (read_at[first] - began) / (read_at[second] - read_at[first])
    tail = (stopped - read_at[last]) / (read_at[last] - read_at[last_but_one])
    start = before + min(head, 1.0) * (held[second] - held[first])
    out[read] = held[read] - held[first] + start
    return float(out[last] + min(tail, 1.0) * (held[last] - held[last_but_one]))


def _rest(direct: Array, ticks: Array, before: float, out: Array) -> float:
    """Fill one rest with the direct reading shifted to join the value at the stop; returns its last value."""
    read = ticks[np.isfinite(direct[ticks])]
    if not len(read):
        return before
    out[read] = direct[read] - direct[read[0]] + before
    return float(out[read[-1]])
