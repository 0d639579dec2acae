"""Noise levels by likelihood.

Measurement noise is what a second shows: the likelihood of each reading given all before. It sees scatter only: where
innovations stay alike for seconds, part of a reading's error lasts, and its noise is not lowered.

Process noise is what only minutes show: it stands for heat that no effect describes, and the errors that it makes build
up so slowly that a likelihood of one second ahead takes them for nothing. So it is scaled by factors that are most
likely where nothing was read: the screw's own, from place to place, at thermometers that are never seen (`unseen`),
then all others together after ten minutes without readings (`blind`), where their proportions stay. Where there are no
others, the screw's own is raised to what these minutes show, and never lowered. Where the recordings tell little about
a factor, it stays near 1.

What stands for lasting errors of single sensors (spread of lags, unknown zeros and their drift) is no noise and is left
alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from estimator.accuracy.blind import Scored, blind
from estimator.accuracy.horizon import errors
from estimator.accuracy.noise_floor import Error, missing_physics, noise_floor
from estimator.accuracy.quality import ChannelQuality, quality
from estimator.batch.trial import Trial
from estimator.batch.trials import Trials, slowed, trials_of
from estimator.errors import SetupError
from estimator.faults.use import Use
from estimator.fit.likelihood import likely
from estimator.fit.noise import ENOUGH, channels_of, coloured, noise_levels, of_places
from estimator.fit.unseen import unseen
from estimator.model import Model
from estimator.work import Progress, Runs, one_thread, silent

WIDEST = np.log(30.0)  # the factor on process noise is sought between 1/30 and 30
STEP = 0.5  # of its logarithm, from which the search begins: there may be several peaks
KNOWN = 1.0  # sd of that logarithm before anything was seen
CLOSE = 0.1  # to which the logarithm of a factor is sought


@dataclass(frozen=True)
class Level:
    """One noise level before and after; `kind` is "measurement" or "process"."""

    path: str
    kind: str
    before: float
    after: float
    unit: str


@dataclass(frozen=True)
class Factors:
    """By which process noise was scaled: the screw's own, and all others; 1 where nothing told it."""

    places: float = 1.0
    others: float = 1.0


@dataclass(frozen=True)
class Tuned:
    """Outcome: the model, its levels, each channel's quality, errors by horizon, and the noise floor of its sensors.

    factors  by which process noise was scaled;  uses: what was used of each recording
    missing  open-loop error over the noise floor, where that is far: noise stands in for physics then; else NaN
    """

    model: Model
    levels: tuple[Level, ...]
    factors: Factors
    before: tuple[ChannelQuality, ...]
    after: tuple[ChannelQuality, ...]
    errors: dict[str, Error]
    floor: Error
    missing: float
    uses: tuple[Use, ...]

    def __repr__(self) -> str:
        """Its noise levels."""
        return "\n".join(f"{one.path:32} {one.before:.4g} -> {one.after:.4g} {one.unit}" for one in self.levels)


@one_thread
def tune(model: Model, runs: Runs) -> Tuned:
    """Set the noise levels of a model by some recordings; every other parameter stays."""
    trials, progress = trials_of(model, runs), runs.progress
    kinds = noise_levels(model, trials)
    if not any(kinds.values()):
        raise SetupError(f"{model.name}: no effect has a noise level; nothing to tune")
    better = _measured(model, trials, kinds["measurement"], progress)
    better, factors = scaled(better, trials, kinds["process"], progress)
    better = _measured(better, trials, kinds["measurement"], progress)
    levels = tuple(
        Level(path, kind, model[path], better[path], model.param(path).unit)
        for kind, paths in kinds.items()
        for path in paths
    )
    found, floor = errors(trials, better), noise_floor(better, trials[0])
    return Tuned(
        better, levels, factors, quality(trials, model), quality(trials, better), found, floor,
        missing_physics(found["open_loop"], floor), trials.uses,
    )  # fmt: skip


def _measured(model: Model, trials: Trials, paths: Sequence[str], progress: Progress) -> Model:
    """Measurement noise by the likelihood a tick ahead; not lowered for channels whose innovations are not white."""
    if not paths:
        return model
    search = likely(model, trials, paths, "measurement noise", progress)
    if search.stopped:
        raise KeyboardInterrupt
    found = search.model
    lower = [path for path in paths if found[path] < model[path]]
    if not lower:
        return found
    judged = {each.channel: each for each in quality(trials, found)}
    kept = [path for path in lower if coloured([judged[c] for c in channels_of(path, model, trials[0])])]
    return found.with_values({path: model[path] for path in kept})


def scaled(
    model: Model, trials: Trials, paths: Sequence[str], progress: Progress = silent, lowest: float = -WIDEST
) -> tuple[Model, Factors]:
    """Process noises scaled to be most likely where nothing was read, and the factors.

    lowest  logarithm of the least factor that is looked at; from 0 on it stays where two looks upwards gain nothing
    """
    places = of_places(paths, model, trials[0]) if paths else []
    slow = Trials(trials.each(lambda trial: slowed(trial, model)), trials.workers)
    if not any(len(unseen(trial, model).error) for trial in slow):
        places = []
    others = [path for path in paths if path not in places]
    model, of_screw = _likeliest(model, slow, places, unseen, "places unseen", progress, lowest)
    if others:
        model, of_others = _likeliest(model, trials, others, blind, "blind minutes", progress, lowest)
        return model, Factors(of_screw, of_others)
    model, again = _likeliest(model, trials, places, blind, "blind minutes", progress, 0.0)
    return model, Factors(of_screw * again)


def _likeliest(
    model: Model, trials: Trials, paths: Sequence[str], scored: Callable[[Trial, Model], Scored],
    stage: str, progress: Progress, lowest: float,
) -> tuple[Model, float]:  # fmt: skip
    """Levels scaled together to be most likely by what is scored, and the factor; 1 where nothing is."""
    if not paths or not any(len(scored(trial, model).error) for trial in trials):
        return model, 1.0
    count = 0

    def at(log_factor: float) -> Model:
        bounded = {p: np.clip(model[p] * np.exp(log_factor), model.param(p).lo, model.param(p).hi) for p in paths}
        return model.with_values({path: float(value) for path, value in bounded.items()})

    def unlikely(log_factor: float) -> float:
        nonlocal count
        count += 1
        moved = at(log_factor)
        value = sum(trials.each(lambda trial: scored(trial, moved).loglike))
        progress(f"{stage}, run {count}: log-likelihood {value:.1f}", count)
        return 0.5 * (log_factor / KNOWN) ** 2 - value

    few = [unlikely(look) for look in (0.0, STEP, 4.0 * STEP)] if lowest == 0.0 else []
    if few and few[0] < min(few[1:]):
        return model, 1.0
    grid = np.arange(lowest, WIDEST, STEP)
    best = grid[np.argmin([unlikely(float(x)) for x in grid])]
    near = max(best - STEP, lowest), min(best + STEP, WIDEST)
    found = scipy.optimize.minimize_scalar(unlikely, bounds=near, method="bounded", options={"xatol": CLOSE})
    if lowest == 0.0 and np.exp(found.x) < ENOUGH:
        return model, 1.0
    return at(found.x), float(np.exp(found.x))
