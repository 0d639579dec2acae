"""A recording at a longer tick: enough for open-loop runs, which see slow heat only."""

from dataclasses import replace

import numpy as np

from estimator.cover import AT_ONCE
from estimator.record import Array, Recording
from estimator.rig import Rig

MOST = 5  # ticks in one
LONGEST_S = 15.0  # a tick that still shows a drive of a few minutes


def serves(rig: Rig) -> int:
    """How many ticks of a rig make one that still serves for slow heat; bodies alone cost little, and are quick."""
    return max(1, min(MOST, round(LONGEST_S / rig.tick_s))) if rig.screw else 1


def coarse(recording: Recording, rig: Rig, ticks: int) -> tuple[Recording, Rig]:
    """Every `ticks` ticks in one, with the rig that has this tick.

    Speed, inputs and stay are means; coverage is the mean weighted by the angle turned, so that the heat of constant
    torque stays where and as large as it was; a channel keeps its last reading and that reading's age, and so does the
    direct reading of the displacement.
    """
    some = AT_ONCE // ticks * ticks
    parts = [recording.rows(slice(k, k + some)) for k in range(0, len(recording) - ticks + 1, some)]
    if not parts:
        return recording, rig
    longer = Recording.joined([_coarse(part, ticks, rig.tick_s).packed() for part in parts])
    return longer, replace(rig, tick_s=rig.tick_s * ticks)


def _coarse(recording: Recording, ticks: int, tick_s: float) -> Recording:
    groups = len(recording) // ticks
    last = recording.rows(slice(ticks - 1, groups * ticks, ticks))
    omega = _grouped(recording.omega, groups, ticks)
    turned = np.nan_to_num(omega) + 1e-9
    coverage = _grouped(np.asarray(recording.coverage), groups, ticks)
    channels, ages = _latest(recording, groups, ticks, tick_s)
    return replace(
        last,
        channels=channels,
        ages_s=ages,
        inputs={name: _shortened(name, recording, groups, ticks) for name in recording.inputs},
        omega=_mean(omega),
        apart_s=np.full(groups, np.nan),  # where the table is at the end of a tick is no longer told
        unevenness=_unevenness(recording, groups, ticks),
        stay=_mean(_grouped(np.asarray(recording.stay), groups, ticks)),
        idle=_idle(_grouped(recording.idle, groups, ticks), omega),
        coverage=np.einsum("gt,gtc->gc", turned, coverage) / turned.sum(axis=1)[:, None],
    )


def _shortened(name: str, recording: Recording, groups: int, ticks: int) -> Array:
    """An input at the longer tick: its mean; of the direct reading the last."""
    column = _grouped(recording.inputs[name], groups, ticks)
    return column[:, -1] if name == "displacement_direct" else _mean(column)


def _grouped(column: Array, groups: int, ticks: int) -> Array:
    return column[: groups * ticks].reshape(groups, ticks, *column.shape[1:])


def _unevenness(recording: Recording, groups: int, ticks: int) -> Array:
    """Mean of speed^2 over the square of the mean speed, over the longer tick."""
    squares = np.nan_to_num(recording.unevenness * recording.omega**2)
    mean = np.nan_to_num(_mean(_grouped(recording.omega, groups, ticks)))
    square = _grouped(squares, groups, ticks).mean(axis=1)
    return np.divide(square, mean**2, out=np.ones_like(mean), where=mean > 0)


def _idle(idle: Array, omega: Array) -> Array:
    """Share of each longer tick in which the screw stands, (groups,), from (groups, ticks); 0 where it never turns."""
    moves = omega > 0.0
    return np.where(moves.any(axis=1), np.where(moves, idle, 1.0).mean(axis=1), 0.0)


def _mean(column: Array) -> Array:
    """Mean over axis 1 of what is known; NaN where nothing is."""
    known = np.isfinite(column)
    count = known.sum(axis=1)
    return np.where(count, np.nansum(column, axis=1) / np.maximum(count, 1), np.nan)


def _latest(recording: Recording, groups: int, ticks: int, tick_s: float) -> tuple[Array, Array]:
    """Last reading of each channel in each group (groups, m), and its age at the group's end, s."""
    values = _grouped(recording.channels, groups, ticks)
    ages = _grouped(recording.ages_s, groups, ticks)
    at = ticks - 1 - np.argmax(np.isfinite(values)[:, ::-1], axis=1)
    pick = np.take_along_axis
    age = pick(ages, at[:, None], axis=1)[:, 0] + (ticks - 1 - at) * tick_s
    value = pick(values, at[:, None], axis=1)[:, 0]
    return value, np.where(np.isfinite(value), age, 0.0)
