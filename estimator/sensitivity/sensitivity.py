"""How the readings would move with each parameter: columns for the engine, which share the data's gains.

A parameter moves what the model puts into the states and what it expects to read,

    B[t] = dF x[t-1] + db[t]          D[t] = dH x_pred[t] + d(offset + lag + late)[t]

and the whitened innovations of these columns are the derivatives of the data's own, the gains held. Their Gram matrix
is the information on the parameters that act on the mean; noise levels have none in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.batch import batch
from estimator.batch.kernels import coast
from estimator.batch.nominal import lagging
from estimator.batch.trial import Posed, Trial
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.tangent import Tangent, tangent
from estimator.state.open_loop import lag_filter
from estimator.state.tangent import ReadingsTangent


def information(trial: Trial, model: Model, paths: Sequence[str], block_s: float) -> Array:
    """Gram matrices (blocks, p + 1, p + 1) of the columns and, last, the data, summed over blocks of time."""
    posed = trial.pose(model)
    B, D, start = columns(trial, posed, model, paths)
    constants = ((0, 0), (0, len(start) - B.shape[1]), (0, 0))  # padded as they are used up: B is what takes memory
    blocks = ((trial.rest.time_s - trial.rest.time_s[0]) // block_s).astype(int)

    def added(ticks: slice) -> tuple[Array, Array]:
        return np.pad(B[ticks], constants), D[ticks]

    return batch.gram(posed.system, added, len(paths), start, np.maximum(blocks, 0))


def columns(trial: Trial, posed: Posed, model: Model, paths: Sequence[str]) -> tuple[Array, Array, Array]:
    """Additions to the states that move (T, n, p), to the readings (T, m, p), and to the first estimate (size, p)."""
    system = posed.system
    x = np.vstack([system.x0, *(chunk.x for chunk in batch.passes(system))])
    T, p = len(system.y), len(paths)
    B, D = np.zeros((T, posed.state.n, p)), np.zeros((T, system.y.shape[1], p))
    start = np.zeros((posed.state.size, p))
    for i, path in enumerate(paths):
        moved = tangent(trial, posed, model, path)
        B[:, :, i], D[:, :, i], start[:, i] = _column(trial, posed, moved, x)
    return B, D, start


def _column(trial: Trial, posed: Posed, moved: Tangent, x: Array) -> tuple[Array, Array, Array]:
    system, at = posed.system, posed.state.temperatures
    nominal = nominal_column(trial, posed, moved)
    readings = moved.readings or _none(posed)
    B = nominal.b + _by_regime(nominal.F, system.regime, x[:-1, at])
    predicted = system.b + x[:-1]
    predicted[:, at] += _by_regime(system.F, system.regime, x[:-1, at]) - x[:-1, at]
    D = nominal.beside + predicted[:, at] @ readings.rows.T
    span = nominal.grown[:, None] * system.spans + system.grown[:, None] * readings.spans
    D += predicted[:, system.column, None] * span
    return B, D, readings.x0


@dataclass(frozen=True)
class NominalColumn:
    """How the open-loop run moves with one parameter.

    b (T, n) response to heat, F (R, n, n); reading (T, m) of each channel, beside: what of it is no temperature of the
    states (offset, lag, late); grown (T,)
    """

    b: Array
    F: Array
    reading: Array
    beside: Array
    grown: Array


def nominal_column(trial: Trial, posed: Posed, moved: Tangent) -> NominalColumn:
    """Take a tangent through the open-loop run."""
    system, run = posed.system, posed.run
    if not moved.moves_states and moved.readings is None:
        none = np.zeros_like(posed.heat)
        return NominalColumn(none, np.zeros_like(system.F), moved.offset, moved.offset, np.zeros(len(none)))
    b, F = _states(trial, posed, moved)
    readings = moved.readings or _none(posed)
    z0 = readings.x0[posed.state.temperatures]
    z = np.vstack([z0, coast(system.F, system.regime, b + _by_regime(F, system.regime, run.z[:-1]), z0)])
    spot = z @ run.readings.rows.T + run.z @ readings.rows.T
    before = np.vstack([run.spot[:1], run.lagged[:-1]])
    keep, ramp = lag_filter(run.readings.tau, run.tick_s)
    pushed = (before - run.spot[:-1]) * readings.keep + np.diff(run.spot, axis=0) * readings.ramp
    lagged = lagging(keep, ramp, spot, pushed)
    late = -np.diff(spot, axis=0) * run.late_share
    grown = (z[1:] - z[0]) @ run.growth + (run.z[1:] - run.z[0]) @ readings.growth
    zeros = posed.state.channel_zeros(readings.x0)
    return NominalColumn(b, F, moved.offset + lagged + late + zeros, moved.offset + lagged - spot[1:] + late, grown)


def _states(trial: Trial, posed: Posed, moved: Tangent) -> tuple[Array, Array]:
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
