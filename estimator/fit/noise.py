"""Noise levels of a model: which there are, whose channels they are of, and whether innovations are coloured."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from estimator.accuracy.quality import ChannelQuality
from estimator.batch.trial import Trial
from estimator.model import Model
from estimator.sensitivity.tangent import tangent

COLOURED = 0.15  # an autocorrelation beyond that of chance from which on innovations are not white
CHANCE = 2.0  # times 1 / sqrt(readings): about the largest of many autocorrelations of white innovations


def levels_in(paths: Iterable[str], model: Model, trials: Iterable[Trial]) -> tuple[str, ...]:
    """Those of some parameters that move what is not known, and nothing of what is predicted."""
    posed = [(trial, trial.pose(model)) for trial in trials]

    def is_level(path: str) -> bool:
        moved = [tangent(trial, at, model, path) for trial, at in posed]
        return any(each.moves_noise for each in moved) and not any(each.moves_mean for each in moved)

    return tuple(filter(is_level, paths))


def noise_levels(model: Model, trials: Iterable[Trial]) -> dict[str, list[str]]:
    """Paths of the parameters that set a noise and nothing else: of measurement, and of the process."""
    posed = [trial.pose(model) for trial in trials]
    kinds: dict[str, list[str]] = {"measurement": [], "process": []}
    for path in model.values:
        moved = [tangent(trial, each, model, path) for trial, each in zip(trials, posed, strict=True)]
        if any(each.moves_mean for each in moved) or not model[path] > 0:
            continue
        if any(np.any(each.network.noise) for each in moved):
            kinds["process"].append(path)
        elif any(each.readings is not None and np.any(each.readings.variance) for each in moved):
            kinds["measurement"].append(path)
    return kinds


def of_places(paths: Sequence[str], model: Model, trial: Trial) -> list[str]:
    """Those process noises that are independent from place to place: the screw's own, not a heat's or a body's."""
    posed = trial.pose(model)
    return [path for path in paths if np.linalg.matrix_rank(tangent(trial, posed, model, path).network.noise[0]) > 1]


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
