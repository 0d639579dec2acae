"""How well a model explains several recordings: log-likelihood, priors, their slope and the information.

    log p(theta | y) = sum over recordings of log p(y | theta)  -  sum of ((theta - theta0) / sd)^2 / 2

Parameters are seen through coordinates: those that move what the model predicts by their own size, noise levels by
their logarithm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.batch.trials import Trials
from estimator.effect import Param
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.objective import BLOCK_S
from estimator.sensitivity.score import score
from estimator.sensitivity.sensitivity import information
from estimator.sensitivity.tangent import tangent

LOG_STEP = 0.02


@dataclass(frozen=True)
class Coordinate:
    """One parameter as the search sees it: theta = size c, or e^c for a noise level."""

    path: str
    param: Param
    size: float
    noise: bool

    def value(self, c: float) -> float:
        """The parameter at this coordinate, inside its bounds."""
        theta = np.exp(c) if self.noise else self.size * c
        return float(np.clip(theta, self.param.lo, self.param.hi))

    def of(self, theta: float) -> float:
        """The coordinate of a parameter's value."""
        return float(np.log(max(theta, self.floor)) if self.noise else theta / self.size)

    def slope(self, c: float) -> float:
        """dtheta / dc."""
        return float(np.exp(c)) if self.noise else self.size

    @property
    def floor(self) -> float:
        """The smallest noise level that has a logarithm."""
        highest = self.param.hi if np.isfinite(self.param.hi) else abs(self.param.value) or 1.0
        return max(self.param.lo, 1e-6 * highest)

    @property
    def bounds(self) -> tuple[float, float]:
        """Lowest and highest coordinate."""
        return self.of(self.param.lo), self.of(self.param.hi)


@dataclass(frozen=True)
class Information:
    """Negative curvature of the log posterior, (p, p) per coordinate, and the spread of its slope over blocks of time.

    data    the readings' part;   prior (p,) the priors' part
    blocks  (blocks, p) slope of each block of ten minutes, noise levels left at zero
    """

    data: Array
    prior: Array
    blocks: Array

    @property
    def whole(self) -> Array:
        """Readings and priors together."""
        return self.data + np.diag(self.prior)


class Posterior:
    """Log posterior of some parameters of a model on some trials, as a function of coordinates (p,)."""

    def __init__(self, model: Model, trials: Trials, paths: Sequence[str]) -> None:
        self.model, self.trials = model, trials
        self.coordinates = [self._coordinate(path) for path in paths]
        self.noise = np.array([c.noise for c in self.coordinates], dtype=bool)

    @property
    def start(self) -> Array:
        """Coordinates of the model as it came."""
        lo, hi = self.bounds
        return np.clip([c.of(self.model[c.path]) for c in self.coordinates], lo, hi)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest coordinates, (p,) each."""
        lo, hi = zip(*(c.bounds for c in self.coordinates), strict=True)
        return np.array(lo), np.array(hi)

    def at(self, c: Array) -> Model:
        """The model at these coordinates."""
        values = {each.path: each.value(x) for each, x in zip(self.coordinates, c, strict=True)}
        return self.model.with_values(values)

    def value(self, c: Array) -> float:
        """Log posterior."""
        model = self.at(c)
        return sum(self.trials.each(lambda trial: trial.loglike(model))) - 0.5 * float((self._off(c) ** 2).sum())

    def slope(self, c: Array) -> tuple[float, Array]:
        """Log posterior and its derivative, (p,)."""
        model, paths = self.at(c), [each.path for each in self.coordinates]
        found = self.trials.each(lambda trial: score(trial, model, paths))
        gradient = sum(slope for _, slope in found) * self.steps(c)
        off = self._off(c)
        value = sum(value for value, _ in found) - 0.5 * float((off**2).sum())
        return value, gradient - off * np.sqrt(self._prior(c))

    def information(self, c: Array) -> Information:
        """Exact in parameters that the mean is linear in; noise levels by differences of the slope."""
        p = len(c)
        data, steps = np.zeros((p, p)), self.steps(c)
        mean = np.flatnonzero(~self.noise)
        model, paths = self.at(c), [self.coordinates[i].path for i in mean]
        grams = (
            np.concatenate(self.trials.each(lambda trial: information(trial, model, paths, BLOCK_S))) if paths else None
        )
        blocks = np.zeros((0 if grams is None else len(grams), p))
        if grams is not None:
            scale = np.append(steps[mean], 1.0)
            grams = grams * scale[:, None] * scale
            data[np.ix_(mean, mean)] = grams[:, :-1, :-1].sum(axis=0)
            blocks[:, mean] = grams[:, :-1, -1]
        prior = self._prior(c)
        if self.noise.any():
            here = self.slope(c)[1]
            for i in np.flatnonzero(self.noise):
                there, step = c.copy(), LOG_STEP if c[i] + LOG_STEP <= self.bounds[1][i] else -LOG_STEP
                there[i] += step
                data[i] = data[:, i] = (here - self.slope(there)[1]) / step
                data[i, i] -= prior[i]
        return Information(data, prior, blocks)

    def _coordinate(self, path: str) -> Coordinate:
        param, value = self.model.param(path), self.model[path]
        moved = [tangent(trial, trial.pose(self.model), self.model, path) for trial in self.trials]
        noise = any(each.moves_noise for each in moved) and not any(each.moves_mean for each in moved)
        return Coordinate(path, param, size(value, param.lo, param.hi), noise)

    def steps(self, c: Array) -> Array:
        """dtheta / dc of each parameter, (p,)."""
        return np.array([each.slope(x) for each, x in zip(self.coordinates, c, strict=True)])

    def _prior(self, c: Array) -> Array:
        """Curvature of the priors, (p,), as if the coordinates were linear."""
        sd = np.array([each.param.sd or np.inf for each in self.coordinates])
        return (self.steps(c) / sd) ** 2

    def _off(self, c: Array) -> Array:
        """(theta - theta0) / sd of each parameter; 0 without a prior."""
        pairs = zip(self.coordinates, c, strict=True)
        return np.array([(e.value(x) - e.param.value) / e.param.sd if e.param.sd else 0.0 for e, x in pairs])


def size(value: float, lo: float, hi: float) -> float:
    """A length to measure a parameter by: its own size, or part of its range where it starts at zero."""
    return abs(value) if value else min(1.0, 0.1 * (hi - lo))
