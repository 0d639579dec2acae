"""Small changes of parameters judged by what they predict on recordings left out.

    minimise  sum over runs of d' S[r] d + sum of ((p - p0) / sd)^2,   d = (-change, 1),   inside the bounds

Each recording is left out once: the changes come from the others, the misfit from that one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from estimator.accuracy.noise_floor import Error
from estimator.batch.trials import Trials
from estimator.missing_effect.moments import Column, Moments, moments
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.objective import prior_roots

RIDGE = 1e-9  # of a direction's own curvature, where two columns are the same


@dataclass(frozen=True)
class Explanation:
    """A set of parameters and how well they explain the recordings.

    change      (k,) of each parameter, from all recordings
    covariance  (k, k) of it, from how independent the readings are taken to be
    misfit      mean square of what is left on recordings left out, 1: as good as a good model; and what the priors add
    error       open-loop error there;  read_um: likewise, of the displacement's readings themselves, their zero out
    runs        misfit of each recording
    """

    chosen: tuple[int, ...]
    change: Array
    covariance: Array
    misfit: float
    error: Error
    read_um: float
    runs: Array

    @property
    def sd(self) -> Array:
        """Of the change, (k,)."""
        return np.sqrt(np.diag(self.covariance))


class Panel:
    """Moments of some recordings about one model, and the parameters that their columns belong to."""

    def __init__(self, columns: Sequence[Column], found: Sequence[Moments]) -> None:
        self.columns, self.found = columns, found
        params = [column.model.param(column.path) for column in columns]
        self.at = np.array([float(column.model[column.path]) for column in columns])
        self._lo = np.array([p.lo for p in params]) - self.at
        self._hi = np.array([p.hi for p in params]) - self.at
        self._prior = prior_roots(params) ** 2
        self._off = self.at - np.array([p.value for p in params])
        self._weighted = np.array([each.weighted for each in found])

    @classmethod
    def of(cls, trials: Trials, model: Model, columns: Sequence[Column]) -> Panel:
        """All recordings about a model, and these parameters."""
        return cls(columns, moments(trials, model, columns))

    def values(self, explained: Explanation, share: float = 1.0) -> dict[str, float]:
        """The parameters after a change, or a share of it, by path."""
        pairs = zip(explained.chosen, explained.change, strict=True)
        return {self.columns[i].path: float(self.at[i] + share * change) for i, change in pairs}

    @property
    def cost(self) -> float:
        """Misfit of all recordings as it stands, with what the priors add, in the units of `judge`."""
        return self.cost_with(self.columns)

    def cost_with(self, columns: Sequence[Column]) -> float:
        """The same with the priors of these parameters."""
        off = [(float(c.model[c.path]) - p.value) / p.sd for c in columns if (p := c.model.param(c.path)).sd]
        return float(self._weighted[:, -1, -1].sum() + sum(x**2 for x in off)) / sum(m.weight for m in self.found)

    def judge(self, parameters: Sequence[int] | None = None) -> Explanation:
        """Free these parameters, by number; all if None."""
        chosen = np.array(range(len(self.columns)) if parameters is None else parameters, dtype=int)
        whole = self._weighted.sum(axis=0)
        change, covariance = self._solve(whole, chosen), self._covariance(whole, chosen)
        several = len(self.found) > 1
        left = [self._solve(whole - own, chosen) if several else change for own in self._weighted]
        runs = np.array([_rest(s, chosen, x) for s, x in zip(self._weighted, left, strict=True)])

        def rms(sums: Sequence[Array], counts: Sequence[int]) -> float:
            rest = sum(_rest(s, chosen, x) for s, x in zip(sums, left, strict=True))
            return float(np.sqrt(max(rest, 0.0) / sum(counts))) if sum(counts) else float("nan")

        weights = np.array([m.weight for m in self.found])
        heat_K, length_um, grown_um = (
            rms([getattr(m, name) for m in self.found], [getattr(m, f"{name}_count") for m in self.found])
            for name in ("heat", "length", "grown")
        )
        misfit = (runs.sum() + self._unlikely(chosen, change)) / weights.sum()
        error = Error(heat_K, grown_um)
        return Explanation(tuple(chosen), change, covariance, float(misfit), error, length_um, runs / weights)

    def with_another(self, new: Moments) -> float:
        """Root of the least misfit on one recording more, where the others and the priors hold the parameters."""
        everything = np.arange(len(self.columns))
        lower, scale, _ = self._factor(self._weighted.sum(axis=0) + new.weighted, everything)
        half = np.linalg.solve(lower, new.weighted[:-1, -1] * scale)
        return float(np.sqrt(max(new.weighted[-1, -1] - half @ half, 0.0)))

    def gains(self, beside: Sequence[int]) -> Array:
        """What each parameter would take off the misfit if it moved, alone beside some others: (k,), in `judge`'s sums.

        gain = change (2 slope - change curvature), with the others' part taken out of slope and curvature
        """
        other = np.array(beside, dtype=int)
        whole = self._weighted.sum(axis=0)
        slope, curvature = whole[:-1, -1].copy(), np.diag(whole)[:-1] + self._prior
        if len(other):
            lower, scale, own = self._factor(whole, other)
            across = np.linalg.solve(lower, whole[other, :-1] * scale[:, None])
            slope -= across.T @ np.linalg.solve(lower, own * scale)
            curvature = curvature - (across**2).sum(axis=0)
        known = curvature > RIDGE * np.diag(whole)[:-1]
        change = np.divide(slope, curvature, out=np.zeros_like(slope), where=known)
        change = np.clip(change, self._lo, self._hi)
        return np.asarray(change * (2 * slope - change * curvature))

    def shows(self) -> Array:
        """Whether each parameter moves any reading, (k,)."""
        return np.diag(self._weighted.sum(axis=0))[:-1] > 0

    def _unlikely(self, chosen: Array, change: Array) -> float:
        """What the priors add for the chosen parameters after a change."""
        return float((self._prior[chosen] * (self._off[chosen] + change) ** 2).sum())

    def _solve(self, sums: Array, chosen: Array) -> Array:
        if not len(chosen):
            return np.zeros(0)
        lower, scale, slope = self._factor(sums, chosen)
        half = np.linalg.solve(lower, slope * scale)
        change = np.linalg.solve(lower.T, half) * scale
        lo, hi = self._lo[chosen], self._hi[chosen]
        if np.any(change < lo) or np.any(change > hi):
            wide = np.maximum(hi, lo + 1e-12)
            change = lsq_linear(lower.T, half, (lo / scale, wide / scale), method="bvls").x * scale
        return np.asarray(change)

    def _covariance(self, sums: Array, chosen: Array) -> Array:
        if not len(chosen):
            return np.zeros((0, 0))
        lower, scale, _ = self._factor(sums, chosen)
        inverse = np.linalg.inv(lower) * scale
        return np.asarray(inverse.T @ inverse)

    def _factor(self, sums: Array, chosen: Array) -> tuple[Array, Array, Array]:
        """Cholesky factor of the scaled curvature, the scale, and the slope."""
        curvature = sums[np.ix_(chosen, chosen)] + np.diag(self._prior[chosen])
        slope = sums[chosen, -1] - self._prior[chosen] * self._off[chosen]
        scale = 1.0 / np.sqrt(np.maximum(np.diag(curvature), 1e-300))
        scaled = curvature * np.outer(scale, scale) + RIDGE * np.eye(len(chosen))
        return np.linalg.cholesky(scaled), scale, slope


def _rest(sums: Array, chosen: Array, change: Array) -> float:
    """d' S d: what is left after a change."""
    d = np.append(-change, 1.0)
    at = np.append(chosen, len(sums) - 1)
    return float(d @ sums[np.ix_(at, at)] @ d)
