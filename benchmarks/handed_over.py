"""Recordings of the virtual rig handed over directly: what its frames would decode to, without the frames."""

from __future__ import annotations

import numpy as np

from drivers.virtual_rig import Run
from estimator.record import Array, Recording
from estimator.rig import Rig

INSTANTS = 20  # of the drive in a tick
LATE_S = 0.005  # a frame after what it tells


def record(run: Run, rig: Rig, speed: float = 1.0, position: float = 1.0) -> Recording:
    """A run as ticks; `speed` and `position` are errors of the drive's signals, 1: none."""
    measured, time_s = run.measured, run.measured.time_s
    channels = np.full((len(time_s), len(rig.names)), np.nan)
    channels[:, : measured.channels.shape[1]] = measured.channels
    ages = np.zeros_like(channels)
    held = rig.index("displacement")
    good = run.holds.reading.state == 0
    frozen = run.holds.frozen_s[good] + LATE_S
    row = np.searchsorted(time_s, frozen)
    inside = row < len(time_s)
    channels[row[inside], held] = run.holds.reading.elongation_um[good][inside]
    ages[row[inside], held] = time_s[row[inside]] - frozen[inside]
    omega, uneven, coverage, place = _drive(run, rig, speed, position)
    around = measured.environment
    direct = np.where(measured.direct.state == 0, measured.direct.elongation_um, np.nan)
    moving = run.motion(time_s)
    inputs = {
        "position": place, "speed": moving.speed_rpm * speed, "current": np.full(len(time_s), np.nan),
        "ambient": around.ambient, "base": around.base, "anchor_bracket": around.bracket_anchor,
        "free_bracket": around.bracket_free, "nut": around.nut, "probe": around.probe, "bar": around.bar,
        "board": measured.board, "displacement_direct": direct,
    }  # fmt: skip
    return Recording(f"{run.name}.blf", time_s, channels, ages, inputs, omega, coverage, unevenness=uneven)


def _drive(run: Run, rig: Rig, speed: float, position: float) -> tuple[Array, Array, Array, Array]:
    """Mean |speed| rad/s, its unevenness and the cover of the cells in each tick; position at its end, mm."""
    assert rig.nut is not None
    ticks = len(run.measured.time_s)
    ends = run.measured.time_s[:, None] + (np.arange(INSTANTS) + 0.5 - INSTANTS) / INSTANTS
    motion = run.motion(ends.ravel())
    centre = rig.nut.centre(motion.position_mm * position)
    half = rig.nut.length_mm / 2
    cover = rig.the_screw().overlap(centre - half, centre + half).reshape(ticks, INSTANTS, -1)
    turned = motion.omega.reshape(ticks, INSTANTS)
    weight = np.where(turned.sum(axis=1, keepdims=True) > 0, turned, 1.0)
    coverage = np.einsum("ti,tic->tc", weight / weight.sum(axis=1, keepdims=True), cover)
    mean = turned.mean(axis=1)
    uneven = np.divide((turned**2).mean(axis=1), mean**2, out=np.ones(ticks), where=mean > 0)
    return mean * speed, uneven, coverage, motion.position_mm.reshape(ticks, INSTANTS)[:, -1] * position
