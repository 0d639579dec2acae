"""Broken channels, and when they have been well for long enough to be taken back."""

from __future__ import annotations

import numpy as np

from estimator.faults.fault import Fault, Tick
from estimator.faults.suspects import STILL
from estimator.record import Array

WELL_S, DRIFT_WELL_S, LONGEST_S = 60.0, 600.0, 3600.0


def latest(rows: Array) -> Array:
    """The last number of each column of (K, m), NaN where there is none."""
    at = np.where(np.isfinite(rows), np.arange(len(rows))[:, None], 0).max(axis=0)
    return np.asarray(rows[at, np.arange(rows.shape[1])])


class Recovery:
    """Since when each broken channel has been within its limit. The time asked for doubles with each fault."""

    def __init__(self, m: int) -> None:
        self._since_s, self._patience_s = np.full(m, np.nan), np.full(m, WELL_S)
        self._stood = np.full(m, np.nan)  # deviation when it was last broken

    def isolate(self, i: int, fault: Fault, deviation: float) -> None:
        """A channel is broken from now on."""
        self._since_s[i], self._stood[i] = np.nan, deviation
        least = DRIFT_WELL_S if fault == Fault.DRIFTING else WELL_S
        self._patience_s[i] = min(max(self._patience_s[i], least), LONGEST_S)

    def pass_by(self, deviation: Array, fault: Array) -> None:
        """Ticks (K, m) in which no broken channel was well."""
        self._since_s[fault > Fault.JUDGED] = np.nan
        self._stood = np.where(fault > Fault.JUDGED, latest(np.vstack([self._stood, deviation])), self._stood)

    def recovered(self, tick: Tick, fault: Array) -> Array:
        """Which of the broken channels are taken back, (m,) bool."""
        broken = (fault > Fault.JUDGED) & tick.read
        near = broken & ~tick.beyond & (tick.repeats < STILL)
        # what stands where it jumped to is not well when the model comes near it: it has to jump back
        crept = np.isnan(self._since_s) & (np.abs(tick.deviation - self._stood) <= tick.limit)
        near &= ~(((fault == Fault.JUMPED) | (fault == Fault.OFF)) & crept)
        self._since_s = np.where(near, np.fmin(self._since_s, tick.time_s), np.nan)
        self._stood = np.where(broken & ~near, tick.deviation, self._stood)
        back = near & (tick.time_s - self._since_s >= self._patience_s)
        self._patience_s[back] *= 2.0
        return np.asarray(back)
