"""Broken channels, and when they have been well for long enough to be taken back."""

from dataclasses import dataclass

import numpy as np

from estimator.faults.fault import Fault
from estimator.faults.jumps import Deviations
from estimator.faults.suspects import STILL
from estimator.record import Array

WELL_S, DRIFT_WELL_S, LONGEST_S = 60.0, 3600.0, 3600.0
FORGIVEN = 10.0  # times as long well as was asked for: what was before counts no more


@dataclass(frozen=True)
class Progress:
    """Of K ticks: which channels are to be taken back (K, m), and what is learnt with each, (K, 3, m)."""

    back: Array
    trail: Array


class Recovery:
    """Since when each broken channel has been within its limit, its silences not counted. The time asked for doubles
    with each fault, and is forgiven in time: one bad reading an hour costs a minute each."""

    def __init__(self, silent_s: Array) -> None:
        """silent_s (m,) without a reading: from then on it is a silence."""
        m, self._silent_s = len(silent_s), silent_s
        self._patience_s, self._back_s = np.full(m, WELL_S), np.full(m, np.inf)
        self._state = np.full((3, m), np.nan)  # well since, s; deviation when it was last not well; last reading, s

    def isolate(self, i: int, fault: Fault, deviation: float, now_s: float) -> None:
        """A channel is broken from now on."""
        if now_s - self._back_s[i] > FORGIVEN * self._patience_s[i]:
            self._patience_s[i] = WELL_S
        self._state[:, i] = np.nan, deviation, now_s
        least = DRIFT_WELL_S if fault in (Fault.DRIFTING, Fault.APART) else WELL_S
        self._patience_s[i] = min(max(self._patience_s[i], least), LONGEST_S)

    def compare(self, time_s: Array, jumps: Deviations, repeats: Array, fault: Array) -> Progress:
        """Which of the channels broken by `fault` (m,) are to be taken back at which tick; nothing is learnt yet."""
        trail, broken = np.empty((len(time_s), *self._state.shape)), fault > Fault.JUDGED
        if not broken.any():
            trail[:] = self._state
            return Progress(np.zeros(jumps.value.shape, dtype=bool), trail)
        stands = (fault == Fault.JUMPED) | (fault == Fault.OFF)
        read = np.isfinite(jumps.value) & broken
        within = read & ~jumps.beyond & (repeats < STILL)
        since_s, stood, read_s = self._state
        for k, now in enumerate(time_s):
            gap_s = np.where(read[k], now - read_s, 0.0)
            since_s = since_s + np.where(gap_s > self._silent_s, gap_s, 0.0)
            read_s = np.where(read[k], now, read_s)
            # what stands where it jumped to is not well when the model comes near it: it has to jump back
            crept = stands & np.isnan(since_s) & (np.abs(jumps.value[k] - stood) <= jumps.limit[k])
            well = within[k] & ~crept
            since_s = np.where(read[k], np.where(well, np.fmin(since_s, now), np.nan), since_s)
            stood = np.where(read[k] & ~well, jumps.value[k], stood)
            trail[k] = since_s, stood, read_s
        return Progress(read & (time_s[:, None] - trail[:, 0] >= self._patience_s), trail)

    def learn(self, progress: Progress, k: int) -> None:
        """Take the first k ticks."""
        self._state = progress.trail[k - 1].copy()
        back = progress.back[k - 1]
        self._back_s[back] = self._state[0][back] + self._patience_s[back]
        self._patience_s[back] = np.minimum(2.0 * self._patience_s[back], LONGEST_S)
