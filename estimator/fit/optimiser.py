"""The way up a log posterior: steps s with (information) s = slope, inside the bounds.

Each step is shortened until the posterior rises, and the information corrected on the way by what the slope did
(Broyden, Fletcher, Goldfarb, Shanno). What enters the model linearly is so found in one step.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import lsq_linear

from estimator.fit.posterior import Posterior
from estimator.record import Array
from estimator.work import Progress

ENOUGH = 0.05  # gain in log posterior that a step must promise, or the search is done
STEPS = 40
HALVINGS = 12


class Optimiser:
    """The way up a log posterior; may be stopped by Ctrl-C at any time and then stands at the best place so far.

    after_step  hears how many steps were made and the log posterior there
    """

    def __init__(self, posterior: Posterior, after_step: Callable[[int, float], None] = lambda n, value: None) -> None:
        self.posterior, self.after_step = posterior, after_step
        self.c = posterior.start
        self.value = self.first = -np.inf
        self.converged = self.stopped = False
        self.steps = 0

    def run(self) -> None:
        """Step until nothing is gained."""
        try:
            self._optimise()
        except KeyboardInterrupt:
            self.stopped = True

    def _optimise(self) -> None:
        posterior = self.posterior
        self.value, slope = posterior.slope(self.c)
        self.first = self.value
        curvature, fresh = self._curvature(), True
        while self.steps < STEPS:
            step = bounded_step(curvature, slope, self.c, posterior.bounds)
            done = slope @ step - 0.5 * step @ curvature @ step < ENOUGH
            if not done:
                step = self._shortened(step, slope)
            if done or not step.any():  # a corrected curvature may promise too little: only a fresh one ends the search
                if fresh:
                    self.converged = bool(done)
                    return
                curvature, fresh = self._curvature(), True
                continue
            value, there = posterior.slope(self.c + step)
            curvature, fresh = corrected(curvature, step, slope - there), False
            self.c, self.value, slope = self.c + step, value, there
            self.steps += 1
            self.after_step(self.steps, self.value)

    def _curvature(self) -> Array:
        return positive(self.posterior.information(self.c).whole)

    def _shortened(self, step: Array, slope: Array) -> Array:
        """The step, halved until the posterior rises by a part of what the slope promises; zeros if it never does."""
        for _ in range(HALVINGS):
            if self.posterior.value(self.c + step) > self.value + 1e-4 * slope @ step:
                return step
            step = step / 2
        return np.zeros_like(step)


def told(progress: Progress, stage: str) -> Callable[[int, float], None]:
    """An `after_step` that tells of each step."""
    return lambda n, value: progress(f"{stage}, run {n}: log-likelihood {value:.1f}", n)


def bounded_step(curvature: Array, slope: Array, c: Array, bounds: tuple[Array, Array]) -> Array:
    """The step (p,) that maximises slope s - s curvature s / 2 and stays inside the bounds."""
    factor = np.linalg.cholesky(curvature)
    lo, hi = bounds[0] - c - 1e-12, bounds[1] - c + 1e-12
    return np.asarray(lsq_linear(factor.T, np.linalg.solve(factor, slope), (lo, hi), method="bvls").x)


def positive(curvature: Array) -> Array:
    """The nearest curvature that is positive in every direction."""
    scale = np.sqrt(np.maximum(np.abs(np.diag(curvature)), 1e-12))
    rates, ways = np.linalg.eigh(curvature / np.outer(scale, scale))
    return np.asarray((ways * np.maximum(np.abs(rates), 1e-8)) @ ways.T * np.outer(scale, scale))


def corrected(curvature: Array, step: Array, change: Array) -> Array:
    """BFGS: the curvature that this change of the slope along this step asks for (damped, Powell 1978)."""
    Bs = curvature @ step
    sBs, sy = step @ Bs, step @ change
    if sy < 0.2 * sBs:
        share = 0.8 * sBs / (sBs - sy)
        change = share * change + (1 - share) * Bs
        sy = step @ change
    return curvature - np.outer(Bs, Bs) / sBs + np.outer(change, change) / sy
