"""Recordings of the virtual rig handed over directly: what its frames would decode to, without the frames."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from drivers.decode.condense import Condenser, Readings
from drivers.frames import Tally
from drivers.virtual_rig import Run, simulate
from estimator.record import Array, Recording
from estimator.rig import Rig

INSTANTS = 20  # of the drive in a tick
LATE_S = 0.005  # a frame after what it tells


def simulated(name: str, rig: Rig, machine: int = 0, seed: int = 1, **options: Any) -> tuple[Recording, Array]:
    """Experiment `name` of a machine as ticks, and the elongation that is true at each, um: (K,)

    `options` go to the virtual rig: plant, cycles, stop_s, seconds ...
    """
    run = simulate(name, machine=machine, seed=seed, **options)
    recording = record(run, rig)
    return recording, np.interp(recording.time_s, run.truth.time_s, run.truth.elongation_um)


def record(
    run: Run, rig: Rig, speed: float = 1.0, position: float = 1.0, shift_mm: float = 0.0, since_s: float = 0.0
) -> Recording:
    """A run as ticks; `speed` and `position` are errors of the drive's signals from a time on, 1: none; `shift_mm` of
    the latter."""
    measured, time_s = run.measured, run.measured.time_s
    around, reading, direct = measured.environment, run.holds.reading, measured.direct
    values = dict(zip(rig.thermometers, measured.channels.T)) | {
        "ambient": around.ambient, "base": around.base, "anchor_bracket": around.bracket_anchor,
        "free_bracket": around.bracket_free, "nut": around.nut, "probe": around.probe, "bar": around.bar,
        "board": measured.board, "displacement_direct": np.where(direct.state == 0, direct.elongation_um, np.nan),
    }  # fmt: skip
    told = {name: (time_s, value) for name, value in values.items()}
    good = reading.state == 0
    told["displacement"] = run.holds.frozen_s[good] + LATE_S, reading.elongation_um[good]
    now = (time_s[:, None] + (np.arange(INSTANTS) + 1.0 - INSTANTS) / INSTANTS).ravel()
    drive, wrong = run.motion(now), now >= since_s
    told |= {
        "position": (now, np.where(wrong, drive.position_mm * position + shift_mm, drive.position_mm)),
        "speed": (now, np.where(wrong, drive.speed_rpm * speed, drive.speed_rpm)),
    }
    readings = {name: _readings(time_s, *each) for name, each in told.items()}
    return replace(Condenser(rig, Tally()).rows(readings, time_s), name=f"{run.name}.blf")


def _readings(time_s: Array, now: Array, value: Array) -> Readings:
    """What is told at some times, in the ticks that close at `time_s`."""
    row = np.searchsorted(time_s, now)
    return Readings(np.arange(len(now)), row, now, value).where(row < len(time_s))
