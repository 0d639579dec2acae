"""Small changes of parameters judged by what they predict on recordings left out.

    minimise  sum over runs of d' S[r] d + |R (p - p0)|^2,   d = (-change, 1),   inside the bounds

with a prior of middle p0 and precision R'R. Each recording is left out once: the changes come from the others, the
misfit from that one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from estimator.accuracy.noise_floor import Error
from estimator.batch.trials import Trials
from estimator.hypotheses.moments import Moments, moments
from estimator.hypotheses.slopes import Column
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.objective import prior_roots
from estimator.sensitivity.prior import Belief, size

RIDGE = 1e-9  # of a direction's own curvature, where two columns are the same
SAME = 1e-6  # short of a correlation of one: rounding
LEAST = 0.25  # of a misfit: no model is known better than from misfits half as large as a good one's


@dataclass(frozen=True)
class Explanation:
    """A set of parameters and how well they explain the recordings.

    change      (k,) of each parameter, from all recordings
    covariance  (k, k) of it, from how independent the readings are taken to be, and how much they are off
    misfit      mean square of what is left on recordings left out, 1: as good as a good model; and what the priors add
    fitted      the same on the recordings that it was fitted to, all of them
    weight      independent readings in that mean
    error       open-loop error there;  read_um: likewise, of the displacement's readings themselves, their zero out
    runs        misfit of each recording
    blocks      (2, runs, blocks): what is left in each block, of temperatures and of the displacement, in shares of
                `misfit`; 0 after a recording's end
    """

    chosen: tuple[int, ...]
    change: Array
    covariance: Array
    misfit: float
    weight: float
    error: Error
    read_um: float
    runs: Array
    blocks: Array
    fitted: float

    @property
    def sd(self) -> Array:
        """Of the change, (k,)."""
        return np.sqrt(np.diag(self.covariance))


class Panel:
    """Moments of some recordings about one model, and the parameters that their columns belong to."""

    def __init__(self, columns: Sequence[Column], found: Sequence[Moments], prior: Belief | None = None) -> None:
        self.columns, self.found = columns, found
        params = [column.model.param(column.path) for column in columns]
        self.at = np.array([float(column.model[column.path]) for column in columns])
        self._lo = np.array([p.lo for p in params]) - self.at
        self._hi = np.array([p.hi for p in params]) - self.at
        prior = prior or Belief(np.array([p.value for p in params]), np.diag(prior_roots(params)))
        self._prior, self._off = prior.root.T @ prior.root, self.at - prior.middle
        self._weighted = np.array([each.weighted for each in found])

    @classmethod
    def of(
        cls,
        trials: Trials,
        model: Model,
        columns: Sequence[Column],
        prior: Belief | None = None,
        own: Model | None = None,
    ) -> "Panel":
        """All recordings about a model, and these parameters; their prior, of tables if None.

        own  a model near this one, at whose values the slopes of its own parameters are taken
        """
        return cls(columns, moments(trials, model, columns, own), prior)

    def believing(self, prior: Belief) -> "Panel":
        """The same moments with another prior."""
        return Panel(self.columns, self.found, prior)

    def values(self, explained: Explanation, share: float = 1.0) -> dict[str, float]:
        """The parameters after a change, or a share of it, by path; one at its bound is there to the last digit."""
        found = {}
        for i, change in zip(explained.chosen, explained.change, strict=True):
            path, param = self.columns[i].path, self.columns[i].model.param(self.columns[i].path)
            found[path] = float(np.clip(self.at[i] + share * change, param.lo, param.hi))
        return found

    @property
    def weight(self) -> float:
        """Independent readings in all recordings."""
        return sum(m.weight for m in self.found)

    @property
    def cost(self) -> float:
        """Misfit of all recordings as it stands, with what the prior adds, in the units of `judge`; inf of none."""
        total = float(self._weighted[:, -1, -1].sum() + self._off @ self._prior @ self._off)
        return total / self.weight if self.weight else np.inf

    @property
    def promise(self) -> float:
        """Share of `cost` that one step of all parameters takes off, if readings move as their slopes say."""
        everything, whole = np.arange(len(self.columns)), self._weighted.sum(axis=0)
        change = self._solve(whole, everything)
        left = float(_rest(whole, everything, change)) + self._unlikely(everything, change)
        return 1.0 - left / self.weight / self.cost

    @property
    def told(self) -> float:
        """Nats by which the recordings tell more of all parameters than is known beforehand: ln det(1 + S P^-1) / 2.

        S is the curvature of a model as good as this one, P the prior's; a parameter without one may be anything of its
        own size.
        """
        params = [(x, c.model.param(c.path)) for c, x in zip(self.columns, self.at, strict=True)]
        own = np.array([size(x, p.lo, p.hi) for x, p in params])
        prior = self._prior + np.diag(np.where(np.diag(self._prior) > 0, 0.0, own**-2.0))
        seen = self._weighted.sum(axis=0)[:-1, :-1] / max(self.cost, LEAST)
        return float(np.linalg.slogdet(seen + prior)[1] - np.linalg.slogdet(prior)[1]) / 2.0

    def judge(self, parameters: Sequence[int] | None = None) -> Explanation:
        """Free these parameters, by number; all if None."""
        chosen = np.array(range(len(self.columns)) if parameters is None else parameters, dtype=int)
        whole = self._weighted.sum(axis=0)
        change = self._solve(whole, chosen)
        rest = float(_rest(whole, chosen, change))
        covariance = self._covariance(whole, chosen, max(rest / self.weight, LEAST))
        several = len(self.found) > 1
        left = [self._solve(whole - own, chosen) if several else change for own in self._weighted]
        runs = np.array([float(_rest(s, chosen, x)) for s, x in zip(self._weighted, left, strict=True)])

        def rms(sums: Sequence[Array], counts: Sequence[int]) -> float:
            square = sum(float(_rest(s, chosen, x)) for s, x in zip(sums, left, strict=True))
            return float(np.sqrt(max(square, 0.0) / sum(counts))) if sum(counts) else float("nan")

        heat_K, length_um, grown_um = (
            rms([getattr(m, name) for m in self.found], [getattr(m, f"{name}_count") for m in self.found])
            for name in ("heat", "length", "grown")
        )
        unlikely = self._unlikely(chosen, change)
        misfit, fitted = ((square + unlikely) / self.weight for square in (runs.sum(), rest))
        weights = np.array([m.weight for m in self.found])
        return Explanation(
            tuple(chosen), change, covariance, float(misfit), self.weight, Error(heat_K, grown_um), length_um,
            runs / weights, self._blocks(chosen, left), float(fitted),
        )  # fmt: skip

    def _blocks(self, chosen: Array, left: Sequence[Array]) -> Array:
        """What changes of the chosen parameters, one set a recording, leave in each block, (2, runs, blocks)."""
        out = np.zeros((2, len(self.found), max(len(m.heats) for m in self.found)))
        for r, (m, change) in enumerate(zip(self.found, left, strict=True)):
            for family, unit, parts in zip(out, m.units, (m.heats, m.lengths), strict=True):
                family[r, : len(parts)] = _rest(parts, chosen, change) * unit / self.weight
        return out

    def with_another(self, new: Moments) -> float:
        """Root of the least misfit on one recording more, where the others and the priors hold the parameters."""
        everything = np.arange(len(self.columns))
        lower, scale, _ = self._factor(self._weighted.sum(axis=0) + new.weighted, everything)
        half = np.linalg.solve(lower, new.weighted[:-1, -1] * scale)
        return float(np.sqrt(max(new.weighted[-1, -1] - half @ half, 0.0)))

    def sd_with_another(self, new: Moments) -> Array:
        """Of each parameter, (k,), after one recording more."""
        everything = np.arange(len(self.columns))
        return np.sqrt(np.diag(self._covariance(self._weighted.sum(axis=0) + new.weighted, everything)))

    def gains(self, beside: Sequence[int]) -> Array:
        """What each parameter would take off the misfit if it moved, alone beside some others: (k,), in `judge`'s sums.

        gain = change (2 slope - change curvature), with the others' part taken out of slope and curvature
        """
        other = np.array(beside, dtype=int)
        whole = self._weighted.sum(axis=0)
        slope, curvature = whole[:-1, -1].copy(), np.diag(whole)[:-1] + np.diag(self._prior)
        if len(other):
            lower, scale, own = self._factor(whole, other)
            across = np.linalg.solve(lower, (whole[other, :-1] + self._prior[other]) * scale[:, None])
            slope -= across.T @ np.linalg.solve(lower, own * scale)
            curvature = curvature - (across**2).sum(axis=0)
        known = curvature > RIDGE * np.diag(whole)[:-1]
        change = np.divide(slope, curvature, out=np.zeros_like(slope), where=known)
        change = np.clip(change, self._lo, self._hi)
        return np.asarray(change * (2 * slope - change * curvature))

    def double(self, others: Sequence[int]) -> Array:
        """Whether each parameter moves all readings in proportion to how one of some others does, (k,)."""
        sums = self._weighted.sum(axis=0)[:-1, :-1]
        size = np.sqrt(np.maximum(np.diag(sums), 1e-300))
        alike = np.abs(sums[others] / np.outer(size[others], size))
        return np.asarray(alike.max(axis=0, initial=0.0) > 1.0 - SAME)

    def shows(self) -> Array:
        """Whether each parameter moves any reading, (k,)."""
        return np.diag(self._weighted.sum(axis=0))[:-1] > 0

    def _unlikely(self, chosen: Array, change: Array) -> float:
        """What the priors add for the chosen parameters after a change."""
        off = self._off[chosen] + change
        return float(off @ self._prior[np.ix_(chosen, chosen)] @ off)

    def _solve(self, sums: Array, chosen: Array) -> Array:
        if not len(chosen):
            return np.zeros(0)
        lower, scale, slope = self._factor(sums, chosen)
        half = np.linalg.solve(lower, slope * scale)
        change = np.linalg.solve(lower.T, half) * scale
        lo, hi = self._lo[chosen], self._hi[chosen]
        if np.any(change < lo) or np.any(change > hi):
            wide = np.maximum(hi, lo + 1e-12)
            change = scipy.optimize.lsq_linear(lower.T, half, (lo / scale, wide / scale), method="bvls").x * scale
        return np.asarray(change)

    @np.errstate(over="ignore")
    def _covariance(self, sums: Array, chosen: Array, few: float = 1.0) -> Array:
        """A^-1 (few S + P) A^-1, A = S + P; of what nothing tells of, and no table either, it is infinite.

        few  the mean square that is left: readings say as much less as they are off more
        """
        if not len(chosen):
            return np.zeros((0, 0))
        lower, scale, _ = self._factor(sums, chosen)
        inverse = np.linalg.inv(lower) * scale
        known = inverse @ self._prior[np.ix_(chosen, chosen)] @ inverse.T
        return np.asarray(inverse.T @ (few * np.eye(len(known)) + (1.0 - few) * known) @ inverse)

    def _factor(self, sums: Array, chosen: Array) -> tuple[Array, Array, Array]:
        """Cholesky factor of the scaled curvature, the scale, and the slope."""
        prior = self._prior[np.ix_(chosen, chosen)]
        curvature = sums[np.ix_(chosen, chosen)] + prior
        slope = sums[chosen, -1] - prior @ self._off[chosen]
        scale = 1.0 / np.sqrt(np.maximum(np.diag(curvature), 1e-300))
        scaled = curvature * np.outer(scale, scale) + RIDGE * np.eye(len(chosen))
        return np.linalg.cholesky(scaled), scale, slope


def _rest(sums: Array, chosen: Array, change: Array) -> Array:
    """d' S d: what is left after a change; of one matrix of sums or of several."""
    d = np.append(-change, 1.0)
    at = np.append(chosen, sums.shape[-1] - 1)
    return np.asarray(sums[..., at[:, None], at] @ d @ d)
