"""Open-loop misfits of some recordings, as least squares take them.

    lasting   (y - y_open_loop) / s sqrt(w / N)
    quick     q(y - y_open_loop) / s_q sqrt(w / N_q)         q(v) = v - mean of v, older ones less by exp(-age / 2 min)
    bodies    C^-1/2 (T_shown - T_body) / sqrt(N)            of bodies that have a thermometer (`bodies`)

What a misfit weighs is told in `sensitivity.objective`: N is the steps of a block. That stands for errors which last as
long; a lag, or how far heat has come a minute after it began, would be known no better than these. What a running mean
of two minutes leaves is mostly the scatter of the sensors, and after the two minutes, N_q steps, it is another: s_q is
what a model at hand leaves of it.

Least squares need products of misfits and of how they move, and no misfit by itself: these are what a recording is
asked for.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from estimator.batch.kernels import remember
from estimator.batch.open_loop import measured, open_loop_misfit, where_measured
from estimator.batch.trial import Trial
from estimator.batch.trials import slow_trials_of
from estimator.fit.bodies import Lumps, body_misfit, body_slope, shown
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.objective import good, weights
from estimator.sensitivity.sensitivity import nominal_columns
from estimator.sensitivity.tangent import tangent
from estimator.work import Runs

MEMORY_S = 120.0


@dataclass(frozen=True)
class Products:
    """v'v of c columns v: misfits, and what a step of each parameter takes off them; sums over ticks.

    lasting, quick  (m, c, c), not weighed;   bodies (bodies, c, c);   along (bodies, c) r'v, r what a body has shown
    """

    lasting: Array
    quick: Array
    bodies: Array
    along: Array

    def __add__(self, other: "Products") -> "Products":
        lasting, quick = self.lasting + other.lasting, self.quick + other.quick
        return Products(lasting, quick, self.bodies + other.bodies, self.along + other.along)


@dataclass(frozen=True)
class Heard:
    """How many readings there are of each channel (m,) and body (bodies,), and r'r of what bodies have shown."""

    channels: Array
    bodies: Array
    shown: Array


class Misfits:
    """Recordings made ready for many open-loop runs."""

    def __init__(self, model: Model, runs: Runs) -> None:
        self.trials = slow_trials_of(model, runs)
        rig, block_s = self.trials[0].rig, self.trials[0].block_s
        weight, quick_s = weights(rig, block_s), max(min(MEMORY_S, block_s), rig.tick_s)
        self._lasting = weight / good(runs.rig) ** 2
        self._quick = weight * block_s / quick_s  # no reading counts more than one
        self._steps, heard = block_s / rig.tick_s, self.trials.each(lambda trial: _heard(trial, model))
        self._heard = Heard(*(sum(getattr(each, key) for each in heard) for key in vars(heard[0])))
        self._weight, self._scatter = float(weight @ self._heard.channels), np.ones(len(weight))
        self._lumps = Lumps(self._heard.bodies, 0.0 * self._heard.bodies, self._heard.shown, self._steps)
        self.weigh(self.at(model))

    def weigh(self, found: Products) -> float:
        """Set s_q of thermometers, and of each other channel, and s of each body to what a model has left.

        Returns the largest share by which one of them has changed.
        """
        heat, heard, quick = self.trials[0].rig.is_thermometer, self._heard, found.quick[:, 0, 0]
        before, alike = np.append(self._scatter, self._lumps.sd_K), [np.flatnonzero(heat)] * int(heat.any())
        self._scatter = np.ones(len(heat))
        for some in (*alike, *np.flatnonzero(~heat)[:, None]):
            self._scatter[some] = _rms(quick[some].sum(), heard.channels[some].sum())
        self._lumps = Lumps(heard.bodies, found.bodies[:, 0, 0], heard.shown, self._steps)
        return float(np.max(np.abs(np.append(self._scatter, self._lumps.sd_K) / before - 1.0)))

    def at(self, model: Model, paths: Sequence[str] = ()) -> Products:
        """Those of v = (f, J): misfits f of all recordings, and J (misfits, p), how they move with parameters."""
        return reduce(Products.__add__, self.trials.each(lambda trial: _products(trial, model, paths)))

    def weighed(self, found: Products) -> tuple[Array, Array]:
        """v'v, (1 + p, 1 + p), of the lasting misfits, and of all others."""
        others = _weighed(found.quick, self._quick / self._scatter**2)
        return _weighed(found.lasting, self._lasting), others + self._lumps.products(found.bodies, found.along)

    def mean_square(self, lasting: Array) -> float:
        """Of lasting misfits, over what a good model leaves."""
        return float(lasting[0, 0] / self._weight)


def _heard(trial: Trial, model: Model) -> Heard:
    """What there is to compare in a recording."""
    of_bodies = shown(trial, trial.pose(model))
    squares = np.nansum(of_bodies**2, axis=0)
    return Heard(measured(trial).sum(axis=0), np.isfinite(of_bodies).sum(axis=0), squares)


def _products(trial: Trial, model: Model, paths: Sequence[str]) -> Products:
    """Those of a recording."""
    posed = trial.pose(model)
    moved = list(nominal_columns(posed, (tangent(trial, posed, model, path) for path in paths)))
    lasting, bodies = open_loop_misfit(trial, posed)[None], body_misfit(trial, posed)[None]
    if moved:
        lasting = np.concatenate([lasting, -where_measured(np.array([column.reading for column in moved]), trial)])
        bodies = np.concatenate([bodies, -body_slope(np.array([column.z for column in moved]), trial, posed)])
    along = np.einsum("ctb,tb->bc", np.nan_to_num(bodies), np.nan_to_num(shown(trial, posed)))
    return Products(_by_itself(lasting), _by_itself(_quick(lasting, trial)), _by_itself(bodies), along)


def _by_itself(columns: Array) -> Array:
    """v'v of columns (c, T, k), NaN: nothing, of each k: (k, c, c)."""
    each = np.ascontiguousarray(np.nan_to_num(columns).transpose(2, 0, 1))
    return np.asarray(each @ each.mT)


def _weighed(products: Array, weight: Array) -> Array:
    return np.asarray((products * weight[:, None, None]).sum(axis=0))


def _quick(values: Array, trial: Trial) -> Array:
    """What a running mean leaves of columns (c, T, m), all finite at the same ticks: every one before weighs less; 0
    before the first."""
    known, keep = np.isfinite(values[0]), np.exp(-trial.rig.tick_s / MEMORY_S)
    still, keep = np.zeros_like(values[:, 0]), np.full(values.shape[2], keep)
    total, count = remember(keep, np.nan_to_num(values), still), remember(keep, known.astype(float), still[0])
    return np.asarray(values - total / np.where(count > 0.0, count, 1.0))


def _rms(square: float, count: float) -> float:
    """Of what is known; 1 where nothing is, or nothing is left."""
    return float(np.sqrt(square / max(count, 1))) or 1.0
