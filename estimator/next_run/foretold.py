"""A run that was not made yet, as a model foretells it."""

from dataclasses import replace

import numpy as np

from estimator.batch.nominal import open_loop
from estimator.inputs.start import Start
from estimator.model import Model
from estimator.network.forcing import Forcing
from estimator.next_run.plans import Plan
from estimator.record import Array, Recording
from estimator.rig import RAD_S, Rig

REST_S = 60.0


def planned(plan: Plan, rig: Rig, level: float) -> Recording:
    """The plan as a recording without readings; temperatures that are inputs at the level."""
    time_s = np.arange(0.0, REST_S + plan.drive_s + plan.stop_s, rig.tick_s)
    driving = (time_s > REST_S) & (time_s <= REST_S + plan.drive_s)
    omega = np.where(driving, _omega(plan, rig), 0.0)
    none = np.full((len(time_s), len(rig.names)), np.nan)
    inputs = {n: np.full(len(time_s), level if s.unit == "degC" else 0.0) for n, s in rig.inputs.items()}
    inputs |= {name: np.where(driving, on, 0.0) for name, on in plan.levels.items()}
    if plan.stroke_mm is not None:
        inputs["position"] = np.full(len(time_s), plan.stroke_mm[0])
    untold = np.full(len(time_s), np.nan)  # the position of a plan goes with no speed
    cover = _coverage(plan, rig, driving)
    return Recording(plan.pattern, time_s, none, np.zeros_like(none), inputs, omega, cover, apart_s=untold)


def _omega(plan: Plan, rig: Rig) -> float:
    """rad/s."""
    return plan.levels["speed"] * RAD_S.get(rig.inputs["speed"].unit, 1.0) if "speed" in plan.levels else plan.omega


def _coverage(plan: Plan, rig: Rig, driving: Array) -> Array:
    """(K, cells): the mean of a stroke while driving, at its start else."""
    if rig.screw is None or rig.nut is None or plan.stroke_mm is None:
        return np.zeros((len(driving), rig.screw.cells if rig.screw else 0))
    centre = rig.nut.centre(np.linspace(*plan.stroke_mm, 50))
    cover = rig.screw.overlap(centre - rig.nut.length_mm / 2, centre + rig.nut.length_mm / 2)
    return np.where(driving[:, None], cover.mean(axis=0), cover[0])


def lived(model: Model, run: Recording, rig: Rig, level: float) -> Recording:
    """The run as the model foretells it; the displacement is read while driving."""
    forcing = Forcing(model, rig, Start(level, 0.0, dict.fromkeys(rig.inputs, 0.0)))
    start = np.full(forcing.place.size, level)
    channels = open_loop(forcing, forcing.read(run), start, run.ages_s)
    for i, name in enumerate(rig.names):
        if name not in rig.thermometers:
            channels[run.omega == 0, i] = np.nan
    return replace(run, channels=channels)
