"""The most likely noise levels, a tick ahead, by their logarithms inside their bounds.

log p(theta | y) = sum over recordings of log p(y | theta)  -  sum of ((theta - theta0) / sd)^2 / 2
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.batch.trials import Trials
from estimator.effect import Param
from estimator.fit.curvature import Curvature
from estimator.fit.noise import channels_of
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.objective import prior_roots
from estimator.sensitivity.score import score
from estimator.work import Progress, silent

ENOUGH = 0.001  # gain in log-likelihood below which a step was the last
LOG_STEP = 0.02
STEPS = 100
LEAST = 0.02  # of a scatter's square, to which one step at most leads
FLAT = 1e-6  # curvature of a direction of which readings say nothing
FLOOR = 1e-6  # of the largest level: the smallest that has a logarithm


@dataclass(frozen=True)
class Likely:
    """The model with its most likely levels; whether the search came to its end, or was stopped by Ctrl-C."""

    model: Model
    converged: bool = True
    stopped: bool = False


class Likelihood:
    """Log-likelihood of some noise levels and their priors, as a function of their logarithms c (p,)."""

    def __init__(self, model: Model, trials: Trials, paths: Sequence[str]) -> None:
        self._model, self._trials, self._paths = model, trials, paths
        params = [model.param(path) for path in paths]
        self._root, self._middle = prior_roots(params), np.array([param.value for param in params])
        self.bounds = np.log([(_floor(param), param.hi) for param in params])
        self.start = np.log([max(model[path], _floor(param)) for path, param in zip(paths, params, strict=True)])

    def at(self, c: Array) -> Model:
        """The model with these levels."""
        return self._model.with_values(dict(zip(self._paths, np.exp(c).tolist(), strict=True)))

    @property
    def readings(self) -> Array:
        """How many readings each level is the scatter of, (p,)."""
        use = [trial.pose(self._model).system.data.use for trial in self._trials]
        first = self._trials[0]
        of = [[first.rig.index(name) for name in channels_of(path, self._model, first)] for path in self._paths]
        return np.array([sum(float(each[:, some].sum()) for each in use) for some in of])

    def slope(self, c: Array) -> tuple[float, Array]:
        """Log-likelihood, and its derivative with respect to c, (p,)."""
        model, level, paths = self.at(c), np.exp(c), self._paths
        found = self._trials.each(lambda trial: score(trial, model, paths))
        off = (level - self._middle) * self._root
        value = sum(value for value, _ in found) - 0.5 * float(off @ off)
        return value, level * (sum(slope for _, slope in found) - off * self._root)

    def covariance(self) -> Array:
        """Of the levels where the model has them, (p, p): the inverse curvature, by differences of the slope."""
        here, rows = self.slope(self.start)[1], []
        for i, hi in enumerate(self.bounds[:, 1]):
            there, step = self.start.copy(), LOG_STEP if self.start[i] + LOG_STEP <= hi else -LOG_STEP
            there[i] += step
            rows.append((here - self.slope(there)[1]) / step)
        rates, ways = np.linalg.eigh(0.5 * (np.array(rows) + np.transpose(rows)))
        ways = ways * np.exp(self.start)[:, None]
        return np.asarray(ways / np.maximum(np.abs(rates), FLAT) @ ways.T)


def likely(model: Model, trials: Trials, paths: Sequence[str], stage: str, progress: Progress = silent) -> Likely:
    """The levels at `paths` made most likely; every other parameter stays. Each evaluation is told under `stage`."""
    target, count = Likelihood(model, trials, paths), 0
    best, highest, slope = target.start, -np.inf, np.zeros(len(paths))

    def told(c: Array) -> Array:
        nonlocal best, highest, slope, count
        count, (value, there) = count + 1, target.slope(c)
        if value > highest:
            best, highest, slope = c, value, there
        progress(f"{stage}, run {count}: log-likelihood {value:.1f}", count)
        return there

    try:
        first, curvature = np.diag(_first_curvature(told(best), target.readings)), Curvature(len(paths))
        for _ in range(STEPS):
            step, gain = curvature.step(-slope, first, target.bounds.T - best)
            if 0.5 * gain < ENOUGH:
                return Likely(target.at(best))
            before = slope
            curvature.learn(step, -before, first, -told(best + step))
    except KeyboardInterrupt:
        return Likely(target.at(best), converged=False, stopped=True)
    return Likely(target.at(best), converged=False)


def _first_curvature(slope: Array, readings: Array) -> Array:
    """Of a log-likelihood by logarithms of levels, (p,), that leads at once to what N readings scatter by.

    -N c - S exp(-2 c) / 2 with S the sum of their squares is highest log(1 + slope / N) / 2 further on.
    """
    share = np.divide(slope, readings, out=np.zeros_like(slope), where=readings > 0)
    further = 0.5 * np.log(np.maximum(1.0 + share, LEAST))
    return np.divide(slope, further, out=np.maximum(np.abs(slope), FLAT), where=further != 0.0)


def _floor(param: Param) -> float:
    highest = param.hi if np.isfinite(param.hi) else abs(param.value) or 1.0
    return max(param.lo, FLOOR * highest)
