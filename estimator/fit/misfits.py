"""Open-loop misfits of some recordings, all in a row as least squares take them.

    lasting   (y - y_open_loop) / s sqrt(w / N)
    quick     q(y - y_open_loop) / s_q sqrt(w / N_q)         q(v) = v - mean of v, older ones less by exp(-age / 2 min)
    bodies    C^-1/2 (T_shown - T_body) / sqrt(N)            of bodies that have a thermometer (`bodies`)

What a misfit weighs is told in `sensitivity.objective`: N is the steps of a block. That stands for errors which last as
long; a lag, or how far heat has come a minute after it began, would be known no better than these. What a running mean
of two minutes leaves is mostly the scatter of the sensors, and after the two minutes, N_q steps, it is another: s_q is
what a model at hand leaves of it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimator.batch.kernels import remember
from estimator.batch.open_loop import measured, open_loop_misfit, where_measured
from estimator.batch.trial import Posed, Trial
from estimator.batch.trials import slow_trials_of
from estimator.fit.bodies import Lumps, body_misfit, body_slope, shown
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.objective import BLOCK_S, good, weights
from estimator.sensitivity.sensitivity import nominal_columns
from estimator.sensitivity.tangent import tangent
from estimator.work import Runs

MEMORY_S = 120.0

Part = tuple[Array, Array, Array]  # lasting and quick, (T, m), and bodies, (T, bodies), of a recording; NaN: none


class Misfits:
    """Recordings made ready for many open-loop runs."""

    def __init__(self, model: Model, runs: Runs) -> None:
        self.trials = slow_trials_of(model, runs)
        tick_s, weight = self.trials[0].rig.tick_s, weights(self.trials[0].rig)
        self._lasting = np.sqrt(weight) / good(runs.rig)
        self._quick = np.sqrt(weight * BLOCK_S / max(MEMORY_S, tick_s))  # no reading counts more than one
        self._steps = BLOCK_S / tick_s
        self._weight = sum(float((weight * measured(trial)).sum()) for trial in self.trials)
        self._shown = np.vstack(self.trials.each(lambda trial: shown(trial, trial.pose(model))))
        self._scatter, self._lumps = np.ones(len(weight)), Lumps(self._shown, np.zeros_like(self._shown), self._steps)
        self.weigh(model)

    def weigh(self, model: Model) -> float:
        """Set s_q of thermometers, and of each other channel, and s of each body to what this model leaves.

        Returns the largest share by which one of them has changed.
        """
        _, each_quick, bodies = zip(*self._parts(model), strict=True)
        quick, heat = np.vstack(each_quick), self.trials[0].rig.is_thermometer
        before = np.append(self._scatter, self._lumps.sd_K)
        self._scatter = np.array([_rms(quick[:, heat if alike else i]) for i, alike in enumerate(heat)])
        self._lumps = Lumps(self._shown, np.vstack(bodies), self._steps)
        return float(np.max(np.abs(np.append(self._scatter, self._lumps.sd_K) / before - 1.0)))

    def of(self, model: Model) -> tuple[Array, Array]:
        """The lasting misfits of all recordings in a row, and all others."""
        return self._rows(self._parts(model))

    def slopes(self, model: Model, paths: Sequence[str]) -> tuple[Array, Array]:
        """How these move with each parameter, (misfits, p) each."""
        of_trials = self.trials.each(lambda trial: _slopes(trial, trial.pose(model), model, paths))
        lasting, others = zip(*(self._rows(parts) for parts in zip(*of_trials, strict=True)), strict=True)
        return np.array(lasting).T, np.array(others).T

    def mean_square(self, lasting: Array) -> float:
        """Of lasting misfits, over what a good model leaves."""
        return float(lasting @ lasting / self._weight)

    def _parts(self, model: Model) -> list[Part]:
        return self.trials.each(lambda trial: _misfits(trial, trial.pose(model)))

    def _rows(self, parts: Sequence[Part]) -> tuple[Array, Array]:
        lasting, quick, bodies = map(np.vstack, zip(*parts, strict=True))
        others = np.append(_known(quick * (self._quick / self._scatter)), self._lumps.white(bodies))
        return _known(lasting * self._lasting), others


def _misfits(trial: Trial, posed: Posed) -> Part:
    """Those of a recording."""
    lasting = open_loop_misfit(trial, posed)
    return lasting, _quick(lasting, trial), body_misfit(trial, posed)


def _slopes(trial: Trial, posed: Posed, model: Model, paths: Sequence[str]) -> list[Part]:
    """What a step of each parameter takes off the misfits of a recording."""
    found = []
    for column in nominal_columns(posed, (tangent(trial, posed, model, path) for path in paths)):
        lasting = -where_measured(column.reading, trial)
        found.append((lasting, _quick(lasting, trial), -body_slope(column.z, trial, posed)))
    return found


def _quick(values: Array, trial: Trial) -> Array:
    """What a running mean leaves of each column's finite values: every row before weighs less; 0 before the first."""
    known, keep = np.isfinite(values), np.exp(-trial.rig.tick_s / MEMORY_S)
    still, keep = np.zeros(values.shape[1]), np.full(values.shape[1], keep)
    total, count = (remember(keep, each, still) for each in (np.nan_to_num(values), known.astype(float)))
    return np.asarray(values - total / np.where(count > 0.0, count, 1.0))


def _known(values: Array) -> Array:
    return np.asarray(values[np.isfinite(values)])


def _rms(values: Array) -> float:
    """Of what is known; 1 where nothing is, or nothing is left."""
    known = _known(values)
    return (float(np.sqrt((known**2).mean())) if len(known) else 0.0) or 1.0
