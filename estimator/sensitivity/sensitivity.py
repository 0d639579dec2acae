"""How the open-loop run moves with each parameter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimator.batch.kernels import coast
from estimator.batch.nominal import lagging
from estimator.batch.trial import Posed, Trial
from estimator.record import Array
from estimator.sensitivity.tangent import Tangent
from estimator.state.open_loop import lag_filter
from estimator.state.tangent import ReadingsTangent


@dataclass(frozen=True)
class NominalColumn:
    """How the open-loop run moves with one parameter: reading (T, m) of each channel, growth of the span (T,), states
    z (T, n)."""

    reading: Array
    grown: Array
    z: Array


def nominal_column(trial: Trial, posed: Posed, moved: Tangent) -> NominalColumn:
    """Take a tangent through the open-loop run."""
    system, run = posed.system, posed.run
    if not moved.moves_states and moved.readings is None:
        return NominalColumn(moved.offset, np.zeros(len(moved.offset)), np.zeros_like(posed.heat))
    readings = moved.readings or _none(posed)
    z0 = readings.x0[posed.state.temperatures]
    z = np.vstack([z0, coast(system.F, system.regime, pushed(posed, moved), z0)])
    spot = z @ run.readings.rows.T + run.z @ readings.rows.T
    before = np.vstack([run.spot[:1], run.lagged[:-1]])
    keep, ramp = lag_filter(run.readings.tau, run.tick_s)
    quick = (before - run.spot[:-1]) * readings.keep + np.diff(run.spot, axis=0) * readings.ramp
    lagged = lagging(keep, ramp, spot, quick)
    late = -np.diff(spot, axis=0) * run.late_share
    grown = (z[1:] - z[0]) @ run.growth + (run.z[1:] - run.z[0]) @ readings.growth
    return NominalColumn(moved.offset + lagged + late + posed.state.channel_zeros(readings.x0), grown, z[1:])


def pushed(posed: Posed, moved: Tangent) -> Array:
    """What each tick adds to how the states move, K, beside what is carried over from the tick before: (T, n)."""
    b, F = _states(posed, moved)
    return np.asarray(b + _by_regime(F, posed.system.regime, posed.run.z[:-1]))


def _states(posed: Posed, moved: Tangent) -> tuple[Array, Array]:
    """How the response to heat, (T, n), and F, (R, n, n), move."""
    regime, forcing, network = posed.system.regime, posed.forcing, moved.network
    b, F = np.zeros_like(posed.heat), np.zeros_like(posed.system.F)
    conducts = np.any(network.mass) or np.any(network.conductance)
    for r in np.unique(regime):
        at = regime == r
        heat = moved.heat[at] + posed.outside[at] @ network.inflow[r].T + moved.outside[at] @ forcing.inflow(r).T
        b[at] = heat @ forcing.transition(r).J.T
        if conducts:
            F[r], J = forcing.modes[r].along(network.mass, network.conductance[r])
            b[at] += posed.heat[at] @ J.T
    return b, F


def _by_regime(F: Array, regime: Array, x: Array) -> Array:
    """F[regime] x of each tick, (T, n)."""
    out = np.zeros_like(x)
    if not np.any(F):
        return out
    for r in np.unique(regime):
        out[regime == r] = x[regime == r] @ F[r].T
    return out


def _none(posed: Posed) -> ReadingsTangent:
    """Readings that do not move."""
    channels, n = posed.run.readings.rows.shape
    return ReadingsTangent.none(channels, n, posed.state.size)
