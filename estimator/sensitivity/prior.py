"""What is known of parameters before recordings are looked at: by tables, or by an earlier fit."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.objective import prior_roots

SURE = 1e-6  # the least variance of a direction, in sd of the parameters: correlations are kept to four digits


@dataclass(frozen=True)
class Belief:
    """Parameters beforehand: their middle (p,), and a matrix (p, p) that makes their distance from it white."""

    middle: Array
    root: Array

    def unlikely(self, values: Array) -> float:
        """Square of the distance of some values (p,) from the middle, in sd."""
        return float(((self.root @ (values - self.middle)) ** 2).sum())


def belief(model: Model, paths: Sequence[str], learned: Collection[str]) -> Belief:
    """Of tables; of those among `learned`, by the model's own values with their sd and correlations, if it has any."""
    params = [model.param(path) for path in paths]
    middle, root = np.array([p.value for p in params], dtype=float), np.diag(prior_roots(params))
    own = [i for i, path in enumerate(paths) if path in learned and model.values[path].sd]
    covariance = model.covariance([paths[i] for i in own])
    sd = np.sqrt(np.diag(covariance))
    rates, ways = np.linalg.eigh(covariance / np.outer(sd, sd))
    middle[own] = [model[paths[i]] for i in own]
    root[np.ix_(own, own)] = (ways / np.sqrt(np.maximum(rates, SURE))).T / sd
    return Belief(middle, root)


def size(value: float, lo: float, hi: float) -> float:
    """A length to measure a parameter by: its own size, or part of its range where it starts at zero."""
    return abs(value) if value else min(1.0, 0.1 * (hi - lo))
