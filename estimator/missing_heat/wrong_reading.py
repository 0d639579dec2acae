"""Which readings are wrong: what a channel shows that no heat explains."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.accuracy.noise_floor import Error
from estimator.missing_heat.follows import Follows, followers_there, follows, reading_series
from estimator.missing_heat.missing_heat import ALL, MissingHeat, moved
from estimator.missing_heat.where import MATTERS, SURE
from estimator.record import Array


@dataclass(frozen=True)
class Wrong:
    """The error of one channel, or of all thermometers together ("thermometers").

    offset, sd  its mean from the first motion on, over all recordings; of the displacement, whose zero has no meaning,
                the mean is no error, and only `rms` tells
    rms         of the whole error;  effect: what that adds to the rms of its kind, over what is good enough
    """

    channel: str
    unit: str
    offset: float
    sd: float
    rms: float
    effect: float
    follows: Follows


def wrong_readings(found: Sequence[MissingHeat], limits: Error) -> tuple[Wrong, ...]:
    """All readings that are surely wrong by what matters, worst first."""
    known = dict.fromkeys(name for each in found for name in each.readings)
    judged = [_judged([each for each in found if name in each.readings], name, limits) for name in known]
    return tuple(sorted((wrong for wrong in judged if wrong is not None), key=lambda wrong: -wrong.effect))


def _judged(found: Sequence[MissingHeat], name: str, limits: Error) -> Wrong | None:
    rig = found[0].misfit.trial.rig
    heat = name == ALL or name in rig.thermometers
    limit = limits.temperature_K if heat else limits.elongation_um
    spent = [_seconds(each, name) for each in found]
    total = max(sum(weights.sum() for weights in spent), 1e-9)
    offset, variance, square, scatter = 0.0, 0.0, 0.0, 0.0
    for each, seconds in zip(found, spent, strict=True):
        error, weights = each.readings[name], seconds / total
        offset += float(weights @ error.mean)
        variance += float(weights @ error.covariance @ weights)
        square += float(weights @ error.mean**2)
        scatter += float(weights @ np.diag(error.covariance))
    rms, sd = float(np.sqrt(square)), float(np.sqrt(max(variance, 0.0)))
    effect = rms / limit * (1.0 if name == ALL else 1.0 / np.sqrt(sum(rig.is_thermometer == heat)))
    if effect < MATTERS or square < SURE**2 * scatter:
        return None
    told = follows([reading_series(each, name) for each in found], followers_there(found[0]), steady=heat)
    return Wrong(name, "K" if heat else "um", offset, sd, rms, float(effect), told)


def _seconds(found: MissingHeat, name: str) -> Array:
    """How much of each bin in which a reading was read lies after the first motion, s."""
    seconds = found.blocks.ticks * moved(found.misfit) * found.misfit.trial.rig.tick_s
    return np.asarray(seconds[found.readings[name].bins])
