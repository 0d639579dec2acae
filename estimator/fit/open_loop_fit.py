"""Parameters with which the model alone follows the measurements: least squares on the open-loop run.

    minimise  sum over runs, ticks, channels of w ((y - y_open_loop(p)) / s)^2 / N  +  sum ((p - p0) / sd_prior)^2

The open-loop run never sees a measurement after the start, so that no process noise can hide a misfit. What a misfit
weighs is told in `sensitivity.objective`: N is the steps of a block. Five seconds a step serve.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, solve_triangular
from scipy.optimize import least_squares

from estimator.batch.open_loop import measured, open_loop_misfit
from estimator.batch.trials import slow_trials_of
from estimator.fit.posterior import size
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.objective import BLOCK_S, good, prior_roots, reading_slope, weights
from estimator.work import Runs

APART = 0.02  # what is left of a column without the others, over itself: below it the column is made of them
EARLIER = 1e-6  # by so much a column is smaller than the one before it, so that of two alike the first is kept


class Objective:
    """Recordings made ready for many open-loop runs."""

    def __init__(self, model: Model, runs: Runs) -> None:
        self._trials = slow_trials_of(model, runs)
        weight = weights(self._trials[0].rig)
        self._scale = good(runs.rig) / np.sqrt(weight)
        self._weight = sum(float((weight * measured(trial)).sum()) for trial in self._trials)

    def misfit(self, model: Model) -> Array:
        """All (y - y_open_loop) / s sqrt(w / N), in a row."""
        posed = [trial.pose(model) for trial in self._trials]
        return self._flat([open_loop_misfit(trial, each) for trial, each in zip(self._trials, posed, strict=True)])

    def mean_square(self, misfit: Array) -> float:
        """Of `misfit`, over what a good model leaves."""
        return float(misfit @ misfit / self._weight)

    def slopes(self, model: Model, paths: Sequence[str]) -> Array:
        """How each of them moves with each parameter, (misfits, p)."""
        posed = [trial.pose(model) for trial in self._trials]
        columns = []
        for path in paths:
            pairs = zip(self._trials, posed, strict=True)
            columns.append(self._flat([-reading_slope(trial, each, model, path) for trial, each in pairs]))
        return np.array(columns).T

    def sums(self, slopes: Array) -> Array:
        """Rows that belong to the misfits, (misfits, p), summed up over blocks of time, (blocks, p)."""
        labels, first = [], 0
        for trial in self._trials:
            block = ((trial.rest.time_s - trial.rest.time_s[0]) // BLOCK_S).astype(int).clip(0)
            labels.append((first + np.repeat(block[:, None], len(trial.rig.names), axis=1))[measured(trial)])
            first += int(block.max()) + 1
        sums = np.zeros((first, slopes.shape[1]))
        np.add.at(sums, np.concatenate(labels), slopes)
        return sums

    def _flat(self, parts: Sequence[Array]) -> Array:
        known = [measured(trial) for trial in self._trials]
        return np.concatenate([(part / self._scale)[at] for part, at in zip(parts, known, strict=True)])


@dataclass(frozen=True)
class Followed:
    """The model that follows best; of what was fitted, (p, p): covariance, curvature^-1 and the data's own curvature.

    paths    parameters fitted;  left: those left where they were, because these recordings cannot tell them from the
             one named with each
    stopped  by Ctrl-C: the best so far
    """

    model: Model
    paths: tuple[str, ...]
    left: Mapping[str, str]
    covariance: Array
    bread: Array
    curvature: Array
    stopped: bool = False


def follow(model: Model, runs: Runs, paths: Sequence[str]) -> Followed:
    """The model with these parameters fitted open loop."""
    objective = Objective(model, runs)
    prior = prior_roots(map(model.param, paths))
    left = untold(np.vstack([objective.slopes(model, paths), np.diag(prior)]), paths) if paths else {}
    paths = [path for path in paths if path not in left]
    if not paths:
        return Followed(model, (), left, *np.zeros((3, 0, 0)))
    params = [model.param(path) for path in paths]
    prior = prior_roots(params)
    start = np.array([model[path] for path in paths])
    unit = np.array([size(value, p.lo, p.hi) for value, p in zip(start, params, strict=True)])
    middle = np.array([p.value for p in params])
    count, best, best_cost = 0, start / unit, np.inf

    def at(scaled: Array) -> Model:
        return model.with_values(dict(zip(paths, scaled * unit, strict=True)))

    def residual(scaled: Array) -> Array:
        nonlocal count, best, best_cost
        rest = objective.misfit(at(scaled))
        all_of_it = np.concatenate([rest, (scaled * unit - middle) * prior])
        if all_of_it @ all_of_it < best_cost:
            best, best_cost = scaled.copy(), all_of_it @ all_of_it
        count += 1
        runs.progress(f"open loop, run {count}: misfit {np.sqrt(objective.mean_square(rest)):.3f}", count)
        return all_of_it

    def jacobian(scaled: Array) -> Array:
        return np.vstack([objective.slopes(at(scaled), paths) * unit, np.diag(prior * unit)])

    bounds = np.array([p.lo for p in params]) / unit, np.array([p.hi for p in params]) / unit
    inside, stopped = np.clip(start / unit, bounds[0] + 1e-6, bounds[1] - 1e-6), False
    try:
        least_squares(residual, inside, jacobian, bounds, x_scale="jac", xtol=1e-4, ftol=1e-5)
    except KeyboardInterrupt:
        stopped = True
    rows = objective.slopes(at(best), paths)
    bread = np.linalg.pinv(rows.T @ rows + np.diag(prior**2))
    rest = objective.misfit(at(best))
    sums = objective.sums(rows * rest[:, None])
    cov = sandwich(bread, sums - sums.mean(axis=0), few=objective.mean_square(rest))
    return Followed(at(best), tuple(paths), left, cov, bread, rows.T @ rows, stopped)


def sandwich(bread: Array, blocks: Array, few: float) -> Array:
    """Covariance (p, p) from curvature^-1 and the slope of each block of time, (blocks, p): A^-1 B A^-1 (White 1982).

    At the best fit the blocks' slopes sum up to zero, so that few of them say little: then curvature^-1 times `few`.
    """
    if len(blocks) <= 3 * len(bread):
        return bread * few
    robust = np.diag(bread @ blocks.T @ blocks @ bread)
    wider = np.sqrt(robust / np.maximum(np.diag(bread), 1e-300))
    return bread * np.outer(wider, wider)


def untold(columns: Array, names: Sequence[str]) -> dict[str, str]:
    """Names of the columns (N, p) that are combinations of those kept, each with the kept one it is most like.

    One without influence is like none (""). Of two that are alike the first is kept.
    """
    norms = np.linalg.norm(columns, axis=0)
    found = {name: "" for name, norm in zip(names, norms, strict=True) if norm == 0.0}
    if len(found) == len(names):
        return found
    seen = norms > 0.0
    first = 1.0 - EARLIER * np.arange(seen.sum())
    _, r, order = qr(columns[:, seen] / norms[seen] * first, mode="economic", pivoting=True)
    sorted_names = [[name for name in names if name not in found][i] for i in order]
    kept = int((np.abs(np.diag(r)) > APART).sum())
    for i, name in enumerate(sorted_names[kept:], kept):
        shares = np.abs(solve_triangular(r[:kept, :kept], r[:kept, i]))
        found[name] = sorted_names[int(shares.argmax())]
    return found
