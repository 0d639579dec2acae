"""Fit a model's free parameters to recordings: least squares on the open-loop run.

    minimise  sum over runs, ticks, channels of ((y - y_open_loop(p)) / s)^2 / N  +  sum ((p - p0) / sd_prior)^2

The open-loop run never sees a measurement after the start, so that no process noise can hide a misfit. s is the misfit
that a good model leaves, not the sensors' scatter: 0.05 K for a thermometer, 0.2 um for the displacement. Such a misfit
stays alike for minutes: a block of ten, N steps, weighs as much as one independent reading.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from estimator.coarse import coarse
from estimator.effect import Param
from estimator.errors import InputError, SetupError
from estimator.filter import Filter
from estimator.forcing import Forcing
from estimator.inputs import Drive
from estimator.model import Model, Value
from estimator.openloop import OpenLoop
from estimator.record import Array, Recording
from estimator.rig import Rig

GOOD_K, GOOD_UM = 0.05, 0.2
EVERY = 5  # ticks in one step of the open-loop run
BLOCK_S = 600.0
AT_BOUND = 1e-3  # of the width between the bounds

Progress = Callable[[int, float], None]


@dataclass(frozen=True)
class Fitted:
    """One fitted parameter: value and sd in `unit` (NaN: it has no influence); whether it ended at a bound."""

    path: str
    before: float
    value: float
    sd: float
    unit: str
    at_bound: bool


@dataclass(frozen=True)
class Fit:
    """A fit's outcome: the model, its parameters, and the open-loop misfit (K, um) before and after."""

    model: Model
    parameters: tuple[Fitted, ...]
    before: tuple[float, float]
    after: tuple[float, float]
    converged: bool
    evaluations: int


@dataclass(frozen=True)
class Run:
    """One recording made ready for many open-loop runs from the same start."""

    forcing: Forcing
    drive: Drive
    z: Array
    measured: Array
    ages_s: Array
    scale: Array

    def residual(self, model: Model) -> Array:
        """(y - y_open_loop) / s, (K, m); each unknown zero taken out as the run's mean."""
        forcing = self.forcing.with_model(model)
        rest = self.measured - open_loop(forcing, self.drive, self.z, self.ages_s)
        for i in np.flatnonzero(forcing.readings.zero_sd > 0):
            if np.isfinite(rest[:, i]).any():
                rest[:, i] -= np.nanmean(rest[:, i])
        return np.asarray(rest / self.scale / np.sqrt(BLOCK_S / forcing.rig.tick_s))


def open_loop(forcing: Forcing, drive: Drive, z: Array, ages_s: Array) -> Array:
    """What the channels read by the model alone from states z on, (K, m)."""
    ticks = forcing.ticks(drive)
    run = OpenLoop(z, forcing.readings, forcing.rig.tick_s)
    out = np.empty_like(ticks.offset)
    for k, (regime, heat) in enumerate(zip(ticks.regime, ticks.heat, strict=True)):
        run.step(forcing.transition(regime), heat)
        out[k] = run.reading + run.late(ages_s[k])
    return out + ticks.offset


def prepare(model: Model, rig: Rig, recording: Recording) -> Run:
    """Read the inputs and find the start of one recording."""
    short, slow = coarse(recording, rig, EVERY)
    first = Filter(model, slow)
    begin = 0
    while not first.started:
        if begin == len(short):
            raise InputError(f"{recording.name}: no thermometer was ever read; nothing to fit")
        first.step(short.sample(begin))
        begin += 1
    rest = short.rows(slice(begin, None))
    scale = np.array([GOOD_K if rig.channels[name].is_thermometer else GOOD_UM for name in rig.names])
    return Run(first.forcing, first.forcing.read(rest), first.open_loop.z, rest.channels, rest.ages_s, scale)


def fit(model: Model, rig: Rig, recordings: Sequence[Recording], each: Progress = lambda n, cost: None) -> Fit:
    """Fit all free parameters to all recordings. `each` hears the evaluations done and the misfit (1: as good as s)."""
    free = model.free()
    if not free:
        raise SetupError(f"{model.name}: every parameter is fixed; nothing to fit")
    runs = [prepare(model, rig, recording) for recording in recordings]
    params = [model.param(path) for path in free]
    start = np.array([model[path] for path in free])
    unit = np.array([_size(value, p.lo, p.hi) for value, p in zip(start, params, strict=True)])
    count = 0

    def residual(scaled: Array) -> Array:
        nonlocal count
        count += 1
        rest = _residual(model.with_values(dict(zip(free, scaled * unit, strict=True))), runs)
        each(count, float(np.sqrt(np.mean(rest**2) * BLOCK_S / runs[0].forcing.rig.tick_s)))
        prior = [(s * u - p.value) / p.sd for s, u, p in zip(scaled, unit, params, strict=True) if p.sd]
        return np.concatenate([rest, prior])

    bounds = np.array([p.lo for p in params]) / unit, np.array([p.hi for p in params]) / unit
    inside = np.clip(start / unit, bounds[0] + 1e-6, bounds[1] - 1e-6)
    found = least_squares(residual, inside, bounds=bounds, x_scale="jac", xtol=1e-4, ftol=1e-5, diff_step=1e-4)
    sd = _sd(found.jac, found.fun, _blocks(runs), BLOCK_S / runs[0].forcing.rig.tick_s) * unit
    fitted = tuple(
        Fitted(path, old, float(x * u), float(s), p.unit, _at_bound(x * u, p))
        for path, old, x, u, s, p in zip(free, start, found.x, unit, sd, params, strict=True)
    )
    better = model.with_values({f.path: Value(f.value, f.sd if np.isfinite(f.sd) else None) for f in fitted})
    about = {"rig": rig.fingerprint(), "fitted_on": {r.name: r.fingerprint for r in recordings}}
    better = replace(better, about={**model.about, **about})
    after = misfit(better, runs)
    better = _doubted(better, rig, after[0])
    return Fit(better, fitted, misfit(model, runs), after, found.status > 0, count)


def _doubted(model: Model, rig: Rig, misfit_K: float) -> Model:
    """The model with at least as much unmodelled heat as its open-loop misfit shows; never with less than before.

    noise = C' m sqrt(L / T): m K beyond the thermometers' scatter, over their mean distance L and a block of time T,
    with C' J/(K m) of the screw. A filter that trusts a model more than that claims an accuracy it does not have.
    """
    places = sorted(c.at_mm for c in rig.channels.values() if c.at_mm is not None)
    if rig.screw is None or len(places) < 2 or not {"conduction.noise", "thermometers.sd"} <= set(model.values):
        return model
    beyond = np.sqrt(max(misfit_K**2 - model["thermometers.sd"] ** 2, 0.0))
    distance = (places[-1] - places[0]) * 1e-3 / (len(places) - 1)
    noise = rig.screw.density * rig.screw.heat_capacity * rig.screw.area * beyond * np.sqrt(distance / BLOCK_S)
    highest = model.param("conduction.noise").hi
    return model.with_values({"conduction.noise": float(np.clip(noise, model["conduction.noise"], highest))})


def misfit(model: Model, runs: Sequence[Run]) -> tuple[float, float]:
    """Open-loop rms over runs: (thermometers in K, displacement in um); NaN where there is none."""
    rests = [run.residual(model) * run.scale * np.sqrt(BLOCK_S / run.forcing.rig.tick_s) for run in runs]
    thermometer = runs[0].scale == GOOD_K
    return _rms([rest[:, thermometer] for rest in rests]), _rms([rest[:, ~thermometer] for rest in rests])


def _rms(rests: Sequence[Array]) -> float:
    values = np.concatenate([rest[np.isfinite(rest)] for rest in rests])
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")


def _residual(model: Model, runs: Sequence[Run]) -> Array:
    rests = [run.residual(model) for run in runs]
    return np.concatenate([rest[np.isfinite(rest)] for rest in rests])


def _size(value: float, lo: float, hi: float) -> float:
    """A length to measure a parameter by: its own size, or part of its range where it starts at zero."""
    return abs(value) if value else min(1.0, 0.1 * (hi - lo))


def _at_bound(value: float, p: Param) -> bool:
    width = p.hi - p.lo if np.isfinite(p.hi - p.lo) else abs(value)
    return bool(min(value - p.lo, p.hi - value) < AT_BOUND * width)


def _sd(jacobian: Array, residual: Array, block: Array, steps: float) -> Array:
    """Standard deviations A^-1 B A^-1 with A = J'J and B summed over blocks of time.

    Residuals of an open-loop run stay alike for minutes, so that neighbours are no independent evidence: what sums up
    inside a block of `steps` steps counts once. Rows beyond the blocks are priors: they add to A only. At the best fit
    the blocks sum up to zero, so that few of them say nothing: then each counts as one reading with the mean misfit.
    NaN for a parameter without influence.
    """
    bread = np.linalg.pinv(jacobian.T @ jacobian)
    blocks, parameters = block.max() + 1, jacobian.shape[1]
    rows, rest = jacobian[: len(block)], residual[: len(block)]
    sums = np.zeros((blocks, parameters))
    np.add.at(sums, block, rows * rest[:, None])
    few = blocks <= 2 * parameters
    middle = np.mean(rest**2) * steps * rows.T @ rows if few else sums.T @ sums
    sd = np.sqrt(np.maximum(np.diag(bread @ middle @ bread), 0.0))
    return np.where(np.any(rows != 0, axis=0), sd, np.nan)


def _blocks(runs: Sequence[Run]) -> Array:
    """Block number of each residual, in the order of `_residual`."""
    labels, first = [], 0
    for run in runs:
        steps = (np.arange(len(run.measured)) * run.forcing.rig.tick_s // BLOCK_S).astype(int)
        known = np.isfinite(run.residual(run.forcing.model))
        labels.append((first + np.repeat(steps[:, None], known.shape[1], axis=1))[known])
        first += int(steps[-1]) + 1
    return np.concatenate(labels)
