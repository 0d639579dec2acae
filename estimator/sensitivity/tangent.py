"""How everything that a model's terms yield on a trial moves with one parameter, by complex step.

The terms are evaluated once at p + i h; the imaginary part over h is the derivative, exact to rounding (Squire and
Trapp 1998). No effect writes a derivative.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimator.batch.trial import Posed, Trial
from estimator.inputs.inputs import nothing
from estimator.model import Model
from estimator.network import assemble
from estimator.network.assemble import Network, Readings
from estimator.record import Array
from estimator.state.open_loop import lag_filter
from estimator.terms import Expand, Lag, Read, Shift

STEP = 1e-30


@dataclass(frozen=True)
class ReadingsTangent:
    """Derivatives of rows (m, n), growth (n,), spans, variance, lag variance, walk, keep and ramp (m,), x0 and P0."""

    rows: Array
    growth: Array
    spans: Array
    variance: Array
    lag_variance: Array
    walk: Array
    keep: Array
    ramp: Array
    x0: Array
    P0: Array


@dataclass(frozen=True)
class Tangent:
    """Derivatives along one parameter: heat (T, n), outside (T, boundaries), offset (T, m) after the first sample."""

    network: Network
    heat: Array
    outside: Array
    offset: Array
    readings: ReadingsTangent | None

    @property
    def moves_noise(self) -> bool:
        """Whether the parameter moves a scatter or what is not known at the start."""
        parts = [self.network.noise]
        if self.readings is not None:
            r = self.readings
            parts += [r.variance, r.lag_variance, r.walk, r.P0]
        return any(np.any(part != 0) for part in parts)

    @property
    def moves_states(self) -> bool:
        """Whether the parameter moves the temperatures after the start."""
        parts = [self.network.mass, self.network.conductance, self.network.inflow, self.heat, self.outside]
        return any(np.any(part != 0) for part in parts)

    @property
    def moves_mean(self) -> bool:
        """Whether the parameter moves what the model predicts."""
        parts = [self.offset]
        if self.readings is not None:
            r = self.readings
            parts += [r.rows, r.growth, r.spans, r.keep, r.ramp]
        return self.moves_states or any(np.any(part != 0) for part in parts)


def tangent(trial: Trial, posed: Posed, model: Model, path: str) -> Tangent:
    """Derivatives along parameter "effect.param"."""
    forcing, drive = posed.forcing, trial.drive
    moved = model.with_values({path: model[path] + 1j * STEP})
    ticks, effects = len(drive.inputs), model.moved_by(path.partition(".")[0])
    of_regimes = [term for name in effects for term in moved.terms_of(name, forcing.regime_inputs(), trial.rig)]
    moves = vars(assemble.network_of(of_regimes, forcing.place, len(forcing.modes)))
    of_ticks = [term for name in effects for term in moved.terms_of(name, drive.inputs, trial.rig)]
    heat = _slope(assemble.heat(of_ticks, forcing.place, ticks, drive.spread))
    offset = _slope(assemble.offsets(of_ticks, trial.rig, ticks))
    outside = np.zeros((ticks, forcing.place.boundaries))
    if any(isinstance(term, Shift) for term in of_ticks):
        outside = _slope(assemble.outside(list(moved.terms(drive.inputs, trial.rig)), drive.inputs, forcing.place))
    readings = None
    if any(isinstance(term, (Read, Lag, Expand)) for term in of_ticks):
        terms = list(moved.terms(nothing(trial.rig), trial.rig))
        readings = _readings(trial, posed, assemble.readings(terms, trial.rig, forcing.place), offset[0])
    network = Network(**{key: _slope(value) for key, value in moves.items()})
    return Tangent(network, heat[1:], outside[1:], offset[1:], readings)


def _readings(trial: Trial, posed: Posed, moved: Readings, offset: Array) -> ReadingsTangent:
    keep, ramp = lag_filter(moved.tau, trial.rig.tick_s)
    known = np.isfinite(moved.sd)
    variance = np.where(known, np.where(known, moved.sd, 1.0) ** 2, 1.0)
    first = posed.offset[0] + 1j * STEP * offset
    x0, P0 = trial.run.estimate(moved, posed.forcing.terms, posed.forcing.place, first)
    every = (
        moved.rows,
        moved.growth,
        moved.spans,
        variance,
        moved.lag_noise**2,
        moved.zero_walk**2,
        keep,
        ramp,
        x0,
        P0,
    )
    return ReadingsTangent(*(_slope(value) for value in every))


def _slope(value: Array) -> Array:
    """Derivative of a value after a complex step."""
    return np.imag(value) / STEP
