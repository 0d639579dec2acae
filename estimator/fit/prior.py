"""What is known of parameters before recordings are looked at: by tables, or by an earlier fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.objective import prior_roots

SURE = 1e-6  # the least variance of a direction, in sd of the parameters: correlations are kept to four digits


def prior_of(model: Model, paths: Sequence[str], learned: bool) -> tuple[Array, Array]:
    """Middle (p,) of the prior of some parameters, and a matrix (p, p) that makes their distance from it white.

    Of tables; where what is learned counts, of the model's own values with their sd and correlations, where it has any.
    """
    params = [model.param(path) for path in paths]
    middle, root = np.array([p.value for p in params], dtype=float), np.diag(prior_roots(params))
    own = [i for i, path in enumerate(paths) if learned and model.values[path].sd]
    covariance = model.covariance([paths[i] for i in own])
    sd = np.sqrt(np.diag(covariance))
    rates, ways = np.linalg.eigh(covariance / np.outer(sd, sd))
    middle[own] = [model[paths[i]] for i in own]
    root[np.ix_(own, own)] = (ways / np.sqrt(np.maximum(rates, SURE))).T / sd
    return middle, root
