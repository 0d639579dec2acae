"""The score: derivatives of a trial's log-likelihood with respect to noise levels of a model.

    dL/dp = sum over regimes, ticks and channels of <dL/d(matrix), d(matrix)/dp>

dL/d(matrix) comes from one backward pass over the recording (batch.score, Fisher's identity), d(matrix)/dp from the
terms by complex step, so that the cost hardly grows with the number of levels. Parameters that move a prediction have
no score: they are fitted open loop (`nominal_columns`).
"""

from collections.abc import Sequence

import numpy as np

from estimator.batch import batch
from estimator.batch.nominal import start_slope
from estimator.batch.trial import Posed, Trial
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.tangent import Tangent, tangent


def score(trial: Trial, model: Model, paths: Sequence[str]) -> tuple[float, Array]:
    """Log-likelihood of a model on a trial and its derivatives with respect to noise levels "effect.param", (p,)."""
    posed = trial.pose(model)
    value, slopes = _slopes(trial, posed)
    return value, np.array([_along(slopes, tangent(trial, posed, model, path)) for path in paths])


def _slopes(trial: Trial, posed: Posed) -> tuple[float, dict[str, Array]]:
    """Log-likelihood, and its derivative with respect to each thing of a Tangent that a noise level moves, by name.

    One backward pass, then through the discretisation, and of the start through the open-loop run.
    """
    system, at = posed.system, posed.state.temperatures
    s = batch.score(system)
    x0, walk = s.x0.copy(), np.zeros(s.R.shape[1])
    x0[at] += start_slope(posed.run, system.F, system.regime, -s.y, s.grown)
    for channel, i in posed.state.zero_of.items():
        walk[channel] = s.Q[:, i, i].sum() * trial.rig.tick_s
    noise = np.array([modes.noise_slope(Q) for modes, Q in zip(posed.forcing.modes, s.Q[:, at, at], strict=True)])
    lag_variance = (s.R * trial.lag**2).sum(axis=0)
    scatter = {"variance": s.R.sum(axis=0), "lag_variance": lag_variance, "walk": walk}
    return s.loglike, {"noise": noise, **scatter, "x0": x0, "P0": s.P0}


def _along(slopes: dict[str, Array], each: Tangent) -> float:
    """Sum of all products of a slope with how the thing moves."""
    moved = vars(each.network) | (vars(each.readings) if each.readings is not None else {})
    return float(sum((slope * moved[name]).sum() for name, slope in slopes.items() if name in moved))
