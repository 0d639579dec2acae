"""Noise levels of a model: which there are, whose channels they are of, and whether innovations are coloured."""

from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np

from estimator.accuracy.quality import ChannelQuality
from estimator.batch.open_loop import open_loop_misfit
from estimator.batch.trial import Trial
from estimator.batch.trials import Trials
from estimator.faults.beside.scatter import Scatter
from estimator.model import Model
from estimator.sensitivity.tangent import tangent

COLOURED = 0.15  # an autocorrelation beyond that of chance from which on innovations are not white
ENOUGH = 1.1  # noise is not raised for less
CHANCE = 2.0  # times 1 / sqrt(readings): about the largest of many autocorrelations of white innovations


@dataclass(frozen=True)
class Touch:
    """What a parameter moves on some recordings: what is predicted, anything not known, and of that these two."""

    mean: bool
    noise: bool
    process: bool
    scatter: bool


def levels_in(paths: Sequence[str], model: Model, trials: Trials) -> tuple[str, ...]:
    """Those of some parameters that move what is not known, and nothing of what is predicted."""
    return tuple(path for path, of in _touched(paths, model, trials).items() if of.noise and not of.mean)


def noise_levels(model: Model, trials: Trials) -> dict[str, list[str]]:
    """Paths of the parameters that set a noise and nothing else: of measurement, and of the process."""
    levels = [path for path in model.values if model[path] > 0]
    touched = {path: of for path, of in _touched(levels, model, trials).items() if not of.mean}
    return {
        "measurement": [path for path, of in touched.items() if of.scatter and not of.process],
        "process": [path for path, of in touched.items() if of.process],
    }


def _touched(paths: Sequence[str], model: Model, trials: Trials) -> dict[str, Touch]:
    of_trials = trials.each(lambda trial: _touched_in(trial, paths, model))
    return {path: Touch(*map(any, zip(*map(astuple, of), strict=True))) for path, *of in zip(paths, *of_trials)}


def _touched_in(trial: Trial, paths: Sequence[str], model: Model) -> list[Touch]:
    posed, found = trial.pose(model), []
    for path in paths:
        moved = tangent(trial, posed, model, path)
        scatters = moved.readings is not None and bool(np.any(moved.readings.variance))
        found.append(Touch(moved.moves_mean, moved.moves_noise, bool(np.any(moved.network.noise)), scatters))
    return found


def of_places(paths: Sequence[str], model: Model, trial: Trial) -> list[str]:
    """Those process noises that are independent from place to place: the screw's own, not a heat's or a body's."""
    posed = trial.pose(model)
    return [path for path in paths if np.linalg.matrix_rank(tangent(trial, posed, model, path).network.noise[0]) > 1]


def scattered(model: Model, trials: Trials) -> tuple[Model, float]:
    """The model with its thermometers' noise raised to what successive readings differ by, and the factor; 1: it was
    enough. What a model lacks lasts, and is not in it."""
    rig, trial = trials[0].rig, trials[0]

    def times(trial: Trial) -> float:
        posed, heard = trial.pose(model), Scatter(trial.rig.is_thermometer)
        heard.hear(open_loop_misfit(trial, posed))
        return heard.times(posed.forcing.readings.sd**2)

    factor = float(np.sqrt(np.median(trials.each(times))))
    if factor < ENOUGH:
        return model, 1.0
    levels = noise_levels(model, trials)["measurement"]
    theirs = [path for path in levels if {*channels_of(path, model, trial)} & {*rig.thermometers}]
    found = {path: min(factor * model[path], model.param(path).hi) for path in theirs}
    return model.with_values(found), factor if found else 1.0


def coloured(channels: Sequence[ChannelQuality]) -> bool:
    """Whether the innovations of most of these channels stay alike for longer than chance makes them."""
    beyond = [c.whiteness - CHANCE / np.sqrt(c.readings) for c in channels if np.isfinite(c.whiteness)]
    return bool(beyond) and float(np.median(beyond)) > COLOURED


def channels_of(path: str, model: Model, trial: Trial) -> list[str]:
    """The channels whose scatter a parameter sets."""
    moved = tangent(trial, trial.pose(model), model, path).readings
    if moved is None:
        return []
    return [name for name, slope in zip(trial.rig.names, moved.variance, strict=True) if slope != 0]
