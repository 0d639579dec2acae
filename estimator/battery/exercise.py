"""A short made-up run of any rig in which everything happens: drives, stops, and every input changes."""

import numpy as np

from estimator.inputs.inputs import Inputs
from estimator.inputs.motion import Motion
from estimator.inputs.start import Start
from estimator.model import Model
from estimator.network.forcing import Drive, Forcing
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.state.open_loop import OpenLoop
from estimator.terms import START

TICKS = 300
FIRST, STOP, SECOND = 5, 150, 220  # ticks: a drive, a stop, another drive at another speed
LEVEL_C = 22.0
RPM = 1667.0  # where the rig has no screw that says another


def instants(rig: Rig) -> Inputs:
    """Inputs of three ticks after a drive and a stop: still parked, then two speeds at different places."""
    omega = np.array([[0.0], [1 / 3], [1.0]]) * _reference(rig)
    rises = {name: np.array([[0.5], [1.0], [2.0]]) for name in (*rig.inputs, START)}
    time_s, turning, since_s, moved = np.array([[900.0, 901, 902], [0, 1, 1], [300, 1, 2], [1, 1, 1]])[:, :, None]
    warmth = np.array([[5.0], [5.1], [5.3]])
    motion = Motion(time_s, turning, since_s, moved, before=((True, 600.0), (False, 299.0)), warmth=warmth)
    coverage, uneven = _coverage(rig, np.array([0.25, 0.35, 0.5])), np.array([[1.0], [1.3], [1.1]])
    return Inputs(omega, coverage, rises, rises, motion, uneven, rig.seats, rest_K=motion.rest_K)


def run(rig: Rig) -> Recording:
    """Inputs of 300 ticks, no channel measured: temperatures rise each at its own pace, others over their range."""
    ticks = np.arange(TICKS)
    omega = np.where((ticks >= FIRST) & (ticks < STOP), 0.6, np.where(ticks >= SECOND, 1.0, 0.0)) * _reference(rig)
    parked = _coverage(rig, np.array([0.5]))
    travel = _coverage(rig, np.linspace(0.3, 0.7, 40)).mean(axis=0)
    inputs = {}
    for i, (name, signal) in enumerate(rig.inputs.items(), start=1):
        within = signal.lo + (signal.hi - signal.lo) * (0.3 + 0.4 * ticks / TICKS)
        inputs[name] = LEVEL_C + i / 60 * ticks if signal.unit == "degC" else within
    gaps = np.full((TICKS, len(rig.names)), np.nan)
    coverage = np.where(omega[:, None] > 0, travel, parked)
    return Recording("exercise", ticks * rig.tick_s, gaps, np.zeros_like(gaps), inputs, omega, coverage)


def open_loop(model: Model, rig: Rig, drive: Recording) -> Array:
    """What the channels read by the model alone, (K, m), all at 22 degC at the start; NaN where no effect reads."""
    forcing = forced(model, rig)
    return alone(forcing, forcing.read(drive))


def forced(model: Model, rig: Rig) -> Forcing:
    """The model as it begins, all at 22 degC."""
    return Forcing(model, rig, Start(LEVEL_C, 0.0, dict.fromkeys(rig.inputs, 0.0)))


def alone(forcing: Forcing, drive: Drive) -> Array:
    """As `open_loop`, of what has been read of a run."""
    ticks = forcing.ticks(drive)
    alone, out = OpenLoop(np.full(forcing.place.size, LEVEL_C), forcing.readings, forcing.rig.tick_s), []
    for regime, heat in zip(ticks.regime, ticks.heat, strict=True):
        alone.step(forcing.transition(regime), heat)
        out.append(alone.reading)
    return np.where(np.isfinite(forcing.readings.sd), np.array(out) + ticks.offset, np.nan)


def _reference(rig: Rig) -> float:
    """The speed at which friction powers are given, rad/s."""
    return (rig.screw.reference_rpm if rig.screw else RPM) * 2 * np.pi / 60


def _coverage(rig: Rig, along: Array) -> Array:
    """Cells under the nut with its middle at these shares of the screw's length, (places, cells)."""
    screw, nut = rig.screw, rig.nut
    if screw is None or nut is None:
        return np.zeros((len(along), screw.cells if screw else 0))
    middle = screw.from_mm + (screw.to_mm - screw.from_mm) * along
    return screw.overlap(middle - nut.length_mm / 2, middle + nut.length_mm / 2)
