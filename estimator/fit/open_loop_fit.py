"""Parameters with which the model alone follows the measurements: least squares on the open-loop run.

    minimise  sum of lasting misfits^2  +  sum of quick and bodies' misfits^2  +  sum ((p - p0) / sd_prior)^2

The open-loop run never sees a measurement after the start, so that no process noise can hide a misfit. What a misfit
weighs is told in `misfits`. Five seconds a step serve.

With C and C_o the curvatures of the first two sums at the best p, D that of the last, and A = C + C_o + D, the errors
of p have

    covariance = A^-1 (few C + C_o + D) A^-1

`few` is the mean square misfit that is left, over that of a good model: readings say as much less as they are off more.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.effect import Param
from estimator.fit.curvature import Curvature
from estimator.fit.misfits import Misfits, Products
from estimator.fit.noise import levels_in
from estimator.fit.untold import untold
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.prior import belief, size
from estimator.state.doubt import root
from estimator.work import Progress, Runs, silent

LEAST = 0.25  # of `few`: no model is known better than from misfits half as large as a good one's
ROUGH, ENOUGH = 0.1, 0.002  # readings' worth of cost: steps that gain less, 0.04 sd, are not looked for; at first
STEPS, POOR = 100, 2  # of one search; that gain less than enough in a row
TRIES, SHORTER = 3, (0.1, 0.5)  # along one step; each by such a part of the one before
EDGE = 1e-6  # from a bound
AT_BOUND = 0.05  # of a prior's sd: nearer to a bound is at it
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
    """The way down to the least misfit, priors included; `best` (p,) is the lowest place seen, in steps of `unit`.

    Steps are Gauss's and Newton's (`curvature`), each as much shorter as leads lower.
    """

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
        self._belief = belief(model, paths, paths if learned else ())
        start = _begun(np.array([model[path] for path in paths]), params, self._belief.middle)
        self._unit = np.array([size(value, p.lo, p.hi) for value, p in zip(start, params, strict=True)])
        self._bounds = np.array([(p.lo, p.hi) for p in params]).T / self._unit + [[EDGE], [-EDGE]]
        self.best, self._least = np.clip(start / self._unit, *self._bounds), np.inf
        self.runs, self.converged, self.stopped = 0, False, False
        self._known: tuple[Array, Products] | None = None

    @property
    def model(self) -> Model:
        """The model at the best place."""
        return self._at(self.best)

    @property
    def covariance(self) -> Array:
        """Of the parameters' errors at the best place, (p, p)."""
        lasting, others = self._misfits.weighed(self._found)
        known = others[1:, 1:] + self._belief.root.T @ self._belief.root
        bread = np.linalg.pinv(lasting[1:, 1:] + known, hermitian=True)
        few = max(self._misfits.mean_square(lasting), LEAST)
        return np.asarray(bread @ (few * lasting[1:, 1:] + known) @ bread)

    def run(self) -> None:
        """Search until no parameter, moved alone by its sd, leads lower."""
        try:
            self._descended(ROUGH)
            self._settled()
            for _ in range(ROUNDS):
                self.converged = self._descended(ENOUGH) and self._settled() and not self._lower_beside()
                if self.converged:
                    return
        except KeyboardInterrupt:
            self.stopped = True

    def _descended(self, enough: float) -> bool:
        """Step after step from the best place; whether at the end none gains enough."""
        self._told(self.best)
        curvature, poor = Curvature(len(self.best)), 0
        for _ in range(STEPS):
            here, least, (slope, square) = self.best, self._least, self._slope(self.best)
            step, gain = curvature.step(slope, square, self._bounds - here)
            if gain < enough:
                return True
            there = self._along(step, slope)
            poor = poor + 1 if least - self._least < enough else 0
            if poor == POOR:
                return True
            curvature.learn(there - here, slope, square, self._slope(there)[0])
        return False

    def _along(self, step: Array, slope: Array) -> Array:
        """The first place along a step that leads lower than where it starts; after some tries the last."""
        here, least, share = self.best, self._least, 1.0
        for _ in range(TRIES):
            there = np.clip(here + share * step, *self._bounds)
            rise, fall = self._told(there) - least, -2.0 * slope @ (there - here)
            if rise < 0.0:
                break
            share *= float(np.clip(0.5 * fall / (fall + rise), *SHORTER))  # where a parabola through both is least
        return self.best if rise < 0.0 else there

    def _slope(self, place: Array) -> tuple[Array, Array]:
        """J'f (p,) and J'J (p, p) of all misfits and the distance from the priors' middle, at a place."""
        found = self._found if place is self.best else self._misfits.at(self._at(place), self._paths)
        off = self._belief.root @ np.column_stack([place * self._unit - self._belief.middle, np.diag(self._unit)])
        scale, (lasting, others) = np.append(1.0, self._unit), self._misfits.weighed(found)
        products = (lasting + others) * np.outer(scale, scale) + off.T @ off
        return products[0, 1:], products[1:, 1:]

    @property
    def _found(self) -> Products:
        """What misfits are at the best place, and how they move."""
        if self._known is None or self._known[0] is not self.best:
            self._known = self.best, self._misfits.at(self.model, self._paths)
        return self._known[1]

    def _settled(self) -> bool:
        """Weigh quick and bodies' misfits by what the best place leaves; whether that is what they were weighed by."""
        changed = self._misfits.weigh(self._found)
        self._least = self._square(self.best, self._found)
        return changed < ALIKE

    def _lower_beside(self) -> bool:
        """Look one sd to each side of the best place; whether it was none."""
        least, here = self._least, self.best
        for step in np.diag(np.sqrt(np.diag(self.covariance)) / self._unit):
            for there in (here - step, here + step):
                beside = np.clip(there, *self._bounds)
                self._noted(beside, self._misfits.at(self._at(beside)))
        return bool(self._least < least - LOWER)

    def _at(self, scaled: Array) -> Model:
        return self._model.with_values(dict(zip(self._paths, scaled * self._unit, strict=True)))

    def _told(self, scaled: Array) -> float:
        """A look that is told; the sum of squares there."""
        found = self._misfits.at(self._at(scaled))
        self.runs += 1
        off = np.sqrt(self._misfits.mean_square(self._misfits.weighed(found)[0]))
        square = self._noted(scaled, found)
        self._progress(f"open loop, run {self.runs}: misfit {off:.3f}", self.runs)
        return square

    def _noted(self, scaled: Array, found: Products) -> float:
        """The sum of squares at a place, which is kept where it is lower than all before."""
        square = self._square(scaled, found)
        if square < self._least:
            self.best, self._least = scaled, square
        return square

    def _square(self, scaled: Array, found: Products) -> float:
        """Of all misfits, and of how far each parameter is from its prior's middle."""
        lasting, others = self._misfits.weighed(found)
        return float(lasting[0, 0] + others[0, 0] + self._belief.unlikely(scaled * self._unit))


def _begun(values: Array, params: Sequence[Param], middle: Array) -> Array:
    """Values (p,) to begin with: what an earlier fit left at its bound begins at its prior's middle (p,).

    A bound is a corner that no slope may lead out of: two circuits of balls seen as one are as wide as the nut.
    """
    room = np.array([min(value - p.lo, p.hi - value) for value, p in zip(values, params, strict=True)])
    return np.where(room < AT_BOUND * np.array([p.sd or 0.0 for p in params]), middle, values)


def _left(misfits: Misfits, model: Model, paths: Sequence[str], learned: bool) -> dict[str, str]:
    """Parameters to leave where they are: without influence, or without a prior and like others without one.

    Where a prior is, it decides what readings cannot.
    """
    if not paths:
        return {}
    lasting, others = misfits.weighed(misfits.at(model, paths))
    square = (lasting + others)[1:, 1:]
    size, prior = np.sqrt(np.diag(square)), belief(model, paths, paths if learned else ()).root
    loose = [i for i in range(len(paths)) if not (prior[:, i].any() and size[i])]
    unit = np.where(size, size, 1.0)
    columns = root(square / np.outer(unit, unit)).T * (size > 0.0)
    return untold(columns[:, loose], [paths[i] for i in loose])
