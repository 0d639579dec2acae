"""The score: derivatives of a trial's log-likelihood with respect to a model's parameters.

    dL/dp = sum over regimes, ticks and channels of <dL/d(matrix), d(matrix)/dp>

dL/d(matrix) comes from one backward pass over the recording (batch.score, Fisher's identity), d(matrix)/dp from the
terms by complex step, so that the cost hardly grows with the number of parameters.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimator.batch import batch
from estimator.batch.nominal import pull_back
from estimator.batch.trial import Posed, Trial
from estimator.errors import SetupError
from estimator.model import Model
from estimator.network.assemble import Network
from estimator.network.discretise import Transition
from estimator.record import Array
from estimator.sensitivity.tangent import Tangent, tangent
from estimator.state.tangent import ReadingsTangent


def score(trial: Trial, model: Model, paths: Sequence[str]) -> tuple[float, Array]:
    """Log-likelihood of a model on a trial and its derivatives with respect to parameters "effect.param", (p,)."""
    posed = trial.pose(model)
    tangents = [tangent(trial, posed, model, path) for path in paths]
    rows = np.zeros(len(trial.rig.names), dtype=bool)
    for each, path in zip(tangents, paths, strict=True):
        if each.readings is not None:
            rows |= np.any(each.readings.rows != 0, axis=1)
            if np.any(each.readings.spans) and np.count_nonzero(posed.system.spans) > 1:
                raise SetupError(f"{path}: it weighs one of several channels that read the elongation; fix it")
    value, slopes = _slopes(trial, posed, rows)
    return value, np.array([_along(slopes, each) for each in tangents])


def _slopes(trial: Trial, posed: Posed, rows: Array) -> tuple[float, Tangent]:
    """Log-likelihood, and its derivative with respect to each thing that a Tangent holds, in the same places.

    One backward pass, then through the open-loop run, the discretisation and the boundaries. `rows` (m,) bool: the
    channels whose row of H some parameter moves.
    """
    system, run, at = posed.system, posed.run, posed.state.temperatures
    s = batch.score(system, rows)
    back = pull_back(run, system.F, system.regime, -s.y, -s.y, s.grown)
    heat, outside, network = _network(posed, s.b[:, at] + back.b, s.F + back.F, s.Q[:, at, at])
    x0 = s.x0.copy()
    x0[at] += back.start
    walk = np.zeros(len(rows))
    for channel, i in posed.state.zero_of.items():
        walk[channel] = s.Q[:, i, i].sum() * trial.rig.tick_s
    variance, lag_variance = s.R.sum(axis=0), (s.R * trial.lag**2).sum(axis=0)
    reads = system.spans != 0  # one channel at most where it matters: its own share of dL/dgrown is all of it
    spans = np.where(reads, (s.grown * run.grown).sum() / np.where(reads, system.spans, 1.0), 0.0)
    readings = ReadingsTangent(
        s.H[:, at] + back.rows, back.growth, spans, variance, lag_variance, walk, back.keep, back.ramp, x0, s.P0
    )
    return s.loglike, Tangent(network, heat, outside, -s.y, readings)


def _network(posed: Posed, b: Array, F: Array, Q: Array) -> tuple[Array, Array, Network]:
    """From the derivatives of each tick's response b and each regime's F and Q to heat (T, n), outside, network."""
    regime, n, regimes = posed.system.regime, posed.state.n, len(posed.forcing.modes)
    heat, outside = np.zeros_like(posed.heat), np.zeros_like(posed.outside)
    inflow = np.zeros((regimes, n, outside.shape[1]))
    mass, conductance, noise = np.zeros((n, n)), *np.zeros((2, regimes, n, n))
    for r in np.unique(regime):
        at = regime == r
        heat[at] = b[at] @ posed.forcing.transition(r).J
        outside[at] = heat[at] @ posed.forcing.inflow(r)
        inflow[r] = heat[at].T @ posed.outside[at]
        given = Transition(F[r], b[at].T @ posed.heat[at], Q[r])
        own, conductance[r], noise[r] = posed.forcing.modes[r].pull_back(given)
        mass += own
    return heat, outside, Network(mass, conductance, inflow, noise)


def _along(slopes: Tangent, each: Tangent) -> float:
    """Sum of all products of a slope with how the thing moves."""
    pairs = [(getattr(slopes, key), getattr(each, key)) for key in ("heat", "outside", "offset")]
    pairs += [(getattr(slopes.network, key), value) for key, value in vars(each.network).items()]
    if each.readings is not None:
        pairs += [(getattr(slopes.readings, key), value) for key, value in vars(each.readings).items()]
    return float(sum((slope * moved).sum() for slope, moved in pairs))
