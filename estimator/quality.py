"""Whether a filter's errors are what it says they are, channel by channel.

NIS       mean of (innovation / its sd)^2: 1 when the noise is right, below 1 when it is too large
whiteness largest autocorrelation of the scaled innovations over lags up to a minute: 0 when nothing is left to predict
in 2 sd   share of innovations inside two of their sd: 95 % when they are normal and the noise is right
blind     NIS and share in 2 sd of what is read after ten minutes without readings
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator import batch
from estimator.blind import blind
from estimator.model import Model
from estimator.record import Array
from estimator.trial import Trial

LAGS_S = 60.0


@dataclass(frozen=True)
class ChannelQuality:
    """Figures of one channel over some recordings; NaN where nothing was read."""

    channel: str
    readings: int
    nis: float
    whiteness: float
    in_2sd: float
    blind_nis: float
    blind_in_2sd: float


def quality(trials: Sequence[Trial], model: Model) -> tuple[ChannelQuality, ...]:
    """One model's filter on some recordings."""
    scaled = [_scaled(trial, model) for trial in trials]
    ahead = [blind(trial, model) for trial in trials]
    z_blind = np.concatenate([each.error / each.sd for each in ahead])
    channel = np.concatenate([each.channel for each in ahead])
    found = []
    for i, name in enumerate(trials[0].rig.names):
        z = np.concatenate([one[:, i][np.isfinite(one[:, i])] for one in scaled])
        white = [_whiteness(one[:, i], trial.rig.tick_s) for one, trial in zip(scaled, trials, strict=True)]
        white = [w for w in white if np.isfinite(w)]
        late = z_blind[channel == i]
        found.append(
            ChannelQuality(
                name, len(z), _square(z), max(white, default=float("nan")), _inside(z), _square(late), _inside(late)
            )
        )
    return tuple(found)


def _scaled(trial: Trial, model: Model) -> Array:
    """Innovations over their sd, (T, m); NaN where not fused, or where a reading first tells its own zero."""
    system = trial.pose(model).system
    chunks = list(batch.passes(system))
    predicted, sd, fused = (
        np.vstack([getattr(chunk, key) for chunk in chunks]) for key in ("predicted", "sd", "fused")
    )
    first = np.cumsum(fused, axis=0) == 1
    first[:, [i for i in range(fused.shape[1]) if i not in trial.unread_zeros]] = False
    return np.where(fused & ~first, (system.y - predicted) / sd, np.nan)


def _square(z: Array) -> float:
    return float(np.mean(z**2)) if len(z) else float("nan")


def _inside(z: Array) -> float:
    return float(np.mean(np.abs(z) <= 2)) if len(z) else float("nan")


def _whiteness(z: Array, tick_s: float) -> float:
    """Largest autocorrelation over lags up to a minute, from the pairs of ticks where both were read."""
    known = np.isfinite(z)
    if known.sum() < 100:
        return float("nan")
    x = np.where(known, z - z[known].mean(), 0.0)
    power, found = (x**2).sum() / known.sum(), []
    for lag in range(1, max(2, round(LAGS_S / tick_s) + 1)):
        pairs = (known[lag:] & known[:-lag]).sum()
        if pairs >= 100:
            found.append(abs((x[lag:] * x[:-lag]).sum() / pairs / power))
    return float(max(found, default=np.nan))
