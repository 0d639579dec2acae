"""Parameters with which the model alone follows the measurements: least squares on the open-loop run.

    minimise  sum of lasting misfits^2  +  sum of quick and bodies' misfits^2  +  sum ((p - p0) / sd_prior)^2

The open-loop run never sees a measurement after the start, so that no process noise can hide a misfit. What a misfit
weighs is told in `misfits`. Five seconds a step serve.

With C and C_o the curvatures of the first two sums at the best p, D that of the last, and A = C + C_o + D, the errors
of p have

    covariance = A^-1 (few C + C_o + D) A^-1

`few` is the mean square misfit that is left, over that of a good model: readings say as much less as they are off more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from estimator.fit.misfits import Misfits
from estimator.fit.noise import levels_in
from estimator.fit.untold import untold
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.prior import belief, size
from estimator.work import Progress, Runs, silent

LEAST = 0.25  # of `few`: no model is known better than from misfits half as large as a good one's
LOWER = 0.01  # readings' worth of cost: what lies lower by more, one sd beside an optimum, shows that it is none
ALIKE = 0.1  # a change of the scatter of quick or bodies' misfits after which it is the same
ROUNDS = 4  # of the search, each from the lowest place beside the optimum before, or with misfits weighed anew


@dataclass(frozen=True)
class Followed:
    """The model that follows best, the parameters fitted (p,) and the covariance (p, p) of their errors.

    left       those left where they were: without influence ("") or like the one named with each
    levels     those that set a noise and move no prediction
    converged  whether nothing lower is left nearby;  stopped: by Ctrl-C;  runs: how many it took
    """

    model: Model
    paths: tuple[str, ...]
    covariance: Array
    left: Mapping[str, str]
    levels: tuple[str, ...]
    converged: bool = True
    stopped: bool = False
    runs: int = 0


def follow(model: Model, runs: Runs, paths: Sequence[str], learned: bool = False) -> Followed:
    """The model with these parameters fitted open loop; `learned`: what it knows of them is their prior, not tables."""
    misfits = Misfits(model, runs)
    levels = levels_in(paths, model, misfits.trials)
    mean = [path for path in paths if path not in levels]
    left = _left(misfits, model, mean, learned)
    told = tuple(path for path in mean if path not in left)
    if not told:
        return Followed(model, (), np.zeros((0, 0)), left, levels)
    search = Search(misfits, model, told, runs.progress, learned)
    search.run()
    return Followed(search.model, told, search.covariance, left, levels, search.converged, search.stopped, search.runs)


class Search:
    """The way down to the least misfit, priors included; `best` (p,) is the lowest place seen, in steps of `unit`."""

    def __init__(
        self,
        misfits: Misfits,
        model: Model,
        paths: Sequence[str],
        progress: Progress = silent,
        learned: bool = False,
    ) -> None:
        self._misfits, self._model, self._paths, self._progress = misfits, model, paths, progress
        params = [model.param(path) for path in paths]
        start = np.array([model[path] for path in paths])
        self._unit = np.array([size(value, p.lo, p.hi) for value, p in zip(start, params, strict=True)])
        self._bounds = np.array([p.lo for p in params]) / self._unit, np.array([p.hi for p in params]) / self._unit
        self._belief = belief(model, paths, paths if learned else ())
        self.best, self._least = self._inside(start / self._unit), np.inf
        self.runs, self.converged, self.stopped = 0, False, False

    @property
    def model(self) -> Model:
        """The model at the best place."""
        return self._at(self.best)

    @property
    def covariance(self) -> Array:
        """Of the parameters' errors at the best place, (p, p)."""
        lasting, others = (rows.T @ rows for rows in self._misfits.slopes(self.model, self._paths))
        known = others + self._belief.root.T @ self._belief.root
        bread = np.linalg.pinv(lasting + known, hermitian=True)
        few = max(self._misfits.mean_square(self._misfits.of(self.model)[0]), LEAST)
        return np.asarray(bread @ (few * lasting + known) @ bread)

    def run(self) -> None:
        """Search until no parameter, moved alone by its sd, leads lower."""
        try:
            for _ in range(ROUNDS):
                start = self._inside(self.best)
                found = scipy.optimize.least_squares(
                    self._heard, start, self._slopes, self._bounds, x_scale="jac", xtol=1e-4, ftol=1e-5
                )
                self.converged = found.status > 0 and self._settled() and not self._lower_beside()
                if self.converged:
                    return
        except KeyboardInterrupt:
            self.stopped = True

    def _settled(self) -> bool:
        """Weigh quick and bodies' misfits by what the best place leaves; whether that is what they were weighed by."""
        changed = self._misfits.weigh(self.model)
        self._least = np.inf
        self._residual(self.best)
        return changed < ALIKE

    def _lower_beside(self) -> bool:
        """Look one sd to each side of the best place; whether it was none."""
        least, here = self._least, self.best
        for step in np.diag(np.sqrt(np.diag(self.covariance)) / self._unit):
            for there in (here - step, here + step):
                self._residual(self._inside(there))
        return bool(self._least < least - LOWER)

    def _inside(self, scaled: Array) -> Array:
        return np.clip(scaled, self._bounds[0] + 1e-6, self._bounds[1] - 1e-6)

    def _at(self, scaled: Array) -> Model:
        return self._model.with_values(dict(zip(self._paths, scaled * self._unit, strict=True)))

    def _heard(self, scaled: Array) -> Array:
        rest = self._residual(scaled)
        self.runs += 1
        self._progress(f"open loop, run {self.runs}: misfit {self._off:.3f}", self.runs)
        return rest

    def _residual(self, scaled: Array) -> Array:
        """All misfits, then how far each parameter is from its prior's middle."""
        lasting, others = self._misfits.of(self._at(scaled))
        self._off = np.sqrt(self._misfits.mean_square(lasting))
        rest = np.concatenate([lasting, others, self._belief.root @ (scaled * self._unit - self._belief.middle)])
        if rest @ rest < self._least:
            self.best, self._least = scaled.copy(), float(rest @ rest)
        return rest

    def _slopes(self, scaled: Array) -> Array:
        return np.vstack([*self._misfits.slopes(self._at(scaled), self._paths), self._belief.root]) * self._unit


def _left(misfits: Misfits, model: Model, paths: Sequence[str], learned: bool) -> dict[str, str]:
    """Parameters to leave where they are: without influence, or without a prior and like others without one.

    Where a prior is, it decides what readings cannot.
    """
    if not paths:
        return {}
    slopes = np.vstack(misfits.slopes(model, paths))
    prior = belief(model, paths, paths if learned else ()).root
    loose = [i for i in range(len(paths)) if not (prior[:, i].any() and slopes[:, i].any())]
    return untold(slopes[:, loose], [paths[i] for i in loose])
