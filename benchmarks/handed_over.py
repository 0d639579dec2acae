"""Recordings of the virtual rig handed over directly: what its frames would decode to, without the frames."""

from collections.abc import Callable, Mapping
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

Lie = Callable[[Array], Array]  # of a signal from some time on


def simulated(name: str, rig: Rig, machine: int = 0, seed: int = 1, **options: Any) -> tuple[Recording, Array]:
    """Experiment `name` of a machine as ticks, and the elongation that is true at each, um: (K,)

    `options` go to the virtual rig: plant, cycles, stop_s, seconds ...
    """
    run = simulate(name, machine=machine, seed=seed, **options)
    recording = record(run, rig)
    return recording, np.interp(recording.time_s, run.truth.time_s, run.truth.elongation_um)


def record(run: Run, rig: Rig, lies: Mapping[str, Lie] | None = None, since_s: float = -np.inf) -> Recording:
    """A run as ticks. From a time on signals of the drive are what `lies` make of them, NaN: not told."""
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
    for name, value in (("position", drive.position_mm), ("speed", drive.speed_rpm)):
        lied = np.append(value[~wrong], lies[name](value[wrong])) if lies and name in lies else value
        told[name] = now[np.isfinite(lied)], lied[np.isfinite(lied)]
    readings = {name: _readings(time_s, *each) for name, each in told.items()}
    return replace(Condenser(rig, Tally()).rows(readings, time_s), name=f"{run.name}.blf")


def _readings(time_s: Array, now: Array, value: Array) -> Readings:
    """What is told at some times, in the ticks that close at `time_s`."""
    row = np.searchsorted(time_s, now)
    return Readings(np.arange(len(now)), row, now, value).where(row < len(time_s))
