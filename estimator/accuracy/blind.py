"""How far the estimate runs off without readings: ten minutes seen, ten minutes blind, and then the readings compared.

One second ahead nothing that lasts can be seen: errors that build up over minutes hide in the readings. A filter whose
process noise is right predicts them ten minutes ahead with errors as large as it says,

    log p = -1/2 sum over scored readings of weight (log(2 pi sd^2) + ((y - predicted) / sd)^2)

each reading by itself (a composite likelihood, Varin 2011). Thermometers share their error: together they weigh as one.
"""

from dataclasses import dataclass, replace

import numpy as np

from estimator.batch import batch
from estimator.batch.trial import Trial
from estimator.model import Model
from estimator.record import Array

BLIND_S = 600.0
LOOK_S = 60.0  # the last readings of a blind stretch that are compared: a displacement comes once a stroke


@dataclass(frozen=True)
class Scored:
    """Scored readings: error and its predicted sd, channel and weight, (s,) each."""

    error: Array
    sd: Array
    channel: Array
    weight: Array

    @property
    def loglike(self) -> float:
        """Composite log-likelihood."""
        return float(-0.5 * (self.weight * (np.log(2 * np.pi * self.sd**2) + (self.error / self.sd) ** 2)).sum())


def blind(trial: Trial, model: Model) -> Scored:
    """Blind stretches over a whole recording, twice, so that each part of it is blind once."""
    tick = trial.rig.tick_s
    stretch, look = max(2, round(BLIND_S / tick)), max(1, round(LOOK_S / tick))
    system = trial.pose(model).system
    errors, sds, channels = [], [], []
    for shift in (0, stretch):
        phase = (np.arange(len(system.y)) + shift) % (2 * stretch)
        hidden = (phase >= stretch)[:, None]
        seen = ~trial.muted & np.isfinite(system.y)
        told = np.cumsum(seen & ~hidden, axis=0) > 0
        told[:, [i for i in range(seen.shape[1]) if i not in trial.unread_zeros]] = True
        ends = (phase >= 2 * stretch - look)[:, None] & seen & told
        at = _last_of_each(ends, phase)
        found = batch.compared(replace(system, muted=trial.muted | hidden), at)
        errors.append((system.y - found.predicted)[at])
        sds.append(found.sd[at])
        channels.append(np.nonzero(at)[1])
    channel = np.concatenate(channels)
    heat = trial.rig.is_thermometer
    weight = np.where(heat, 1.0 / max(heat.sum(), 1), 1.0)[channel]
    return Scored(np.concatenate(errors), np.concatenate(sds), channel, weight)


def _last_of_each(ends: Array, phase: Array) -> Array:
    """Of the marked readings (T, m) of each blind stretch, the last one of each channel."""
    out = np.zeros_like(ends)
    stretch = np.cumsum(np.diff(phase, prepend=phase[:1]) < 0)
    for k in np.unique(stretch):
        rows = np.flatnonzero(stretch == k)
        part = ends[rows]
        for channel in np.flatnonzero(part.any(axis=0)):
            out[rows[np.flatnonzero(part[:, channel])[-1]], channel] = True
    return out
