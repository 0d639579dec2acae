"""Whether a filter's errors are what it says they are, channel by channel.

NIS       mean of (innovation / its sd)^2: 1 when the noise is right, below 1 when it is too large
whiteness largest autocorrelation of the scaled innovations over lags up to a minute: 0 when nothing is left to predict
in 2 sd   share of innovations inside two of their sd: 95 % when they are normal and the noise is right
blind     NIS and share in 2 sd of what is read after ten minutes without readings
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.accuracy.blind import blind
from estimator.batch import batch
from estimator.batch.trial import Trial
from estimator.batch.trials import Trials
from estimator.model import Model
from estimator.record import Array

LAGS_S = 60.0
PAIRS = 100  # an autocorrelation from fewer pairs of readings is chance


@dataclass(frozen=True)
class ChannelQuality:
    """Figures of one channel over some recordings; NaN where nothing was read."""

    channel: str
    readings: int
    nis: float
    whiteness: float
    in_2sd: float
    blind_readings: int
    blind_nis: float
    blind_in_2sd: float


@dataclass(frozen=True)
class Innovations:
    """One model's innovations on one recording.

    time_s           (T,) s
    scaled           (T, m) innovation over its sd; NaN where not fused, or where a reading first tells its own zero
    lags_s           (lags,) s: 0 ... a minute
    autocorrelation  (m, lags) of the scaled ones; NaN where too few were read
    """

    time_s: Array
    scaled: Array
    lags_s: Array
    autocorrelation: Array

    @property
    def whiteness(self) -> Array:
        """(m,) largest autocorrelation but that of lag 0; NaN where there is none."""
        size = np.abs(self.autocorrelation[:, 1:])
        return np.where(np.isfinite(size).any(axis=1), np.nan_to_num(size).max(axis=1), np.nan)


def innovations(trial: Trial, model: Model) -> Innovations:
    """What a model's filter did not expect on one recording, a tick ahead."""
    scaled, tick_s = _scaled(trial, model), trial.rig.tick_s
    lags = np.arange(max(2, round(LAGS_S / tick_s) + 1))
    return Innovations(trial.rest.time_s, scaled, lags * tick_s, _autocorrelation(scaled, len(lags)))


def quality(trials: Trials, model: Model) -> tuple[ChannelQuality, ...]:
    """One model's filter on some recordings."""
    near = trials.each(lambda trial: innovations(trial, model))
    ahead = trials.each(lambda trial: blind(trial, model))
    z_blind = np.concatenate([each.error / each.sd for each in ahead])
    channel = np.concatenate([each.channel for each in ahead])
    white = np.array([each.whiteness for each in near])
    found = []
    for i, name in enumerate(trials[0].rig.names):
        z = np.concatenate([each.scaled[:, i] for each in near])
        z, late = z[np.isfinite(z)], z_blind[channel == i]
        whitest = max(white[np.isfinite(white[:, i]), i], default=np.nan)
        near_by = len(z), _square(z), float(whitest), _inside(z)
        found.append(ChannelQuality(name, *near_by, len(late), _square(late), _inside(late)))
    return tuple(found)


def overall(found: Sequence[ChannelQuality], name: str = "all") -> ChannelQuality:
    """All channels together: every reading counts alike; the whiteness is the worst one."""

    def mean(key: str, weight: str) -> float:
        known = [each for each in found if getattr(each, weight)]
        total = sum(getattr(each, weight) for each in known)
        return sum(getattr(each, key) * getattr(each, weight) for each in known) / total if total else float("nan")

    white = max((each.whiteness for each in found if np.isfinite(each.whiteness)), default=float("nan"))
    return ChannelQuality(
        name, sum(each.readings for each in found), mean("nis", "readings"), white, mean("in_2sd", "readings"),
        sum(each.blind_readings for each in found), mean("blind_nis", "blind_readings"),
        mean("blind_in_2sd", "blind_readings"),
    )  # fmt: skip


def _scaled(trial: Trial, model: Model) -> Array:
    """Innovations over their sd, (T, m), and NaN as `Innovations` says."""
    system = trial.pose(model).system
    found, fused = batch.compared(system, system.data.use), system.data.use
    first = np.cumsum(fused, axis=0) == 1
    first[:, [i for i in range(fused.shape[1]) if i not in trial.unread_zeros]] = False
    return np.where(fused & ~first, (system.y - found.predicted) / found.sd, np.nan)


def _square(z: Array) -> float:
    return float(np.mean(z**2)) if len(z) else float("nan")


def _inside(z: Array) -> float:
    return float(np.mean(np.abs(z) <= 2)) if len(z) else float("nan")


def _autocorrelation(z: Array, lags: int) -> Array:
    """(m, lags) of z (T, m), from the pairs of ticks where both were read."""
    known = np.isfinite(z)
    count = known.sum(axis=0)
    mean = np.where(known, z, 0.0).sum(axis=0) / np.maximum(count, 1)
    x = np.where(known, z - mean, 0.0)
    found = np.full((z.shape[1], lags), np.nan)
    for lag in range(min(lags, len(z))):
        rest = len(z) - lag
        pairs = (known[lag:] & known[:rest]).sum(axis=0)
        power = np.sqrt((known[:rest] * x[lag:] ** 2).sum(axis=0) * (known[lag:] * x[:rest] ** 2).sum(axis=0))
        enough = (pairs >= PAIRS) & (power > 0)
        product = (x[lag:] * x[:rest]).sum(axis=0)
        found[enough, lag] = product[enough] / power[enough]
    return found
