"""Thermometers that are beyond their limit alone: what becomes of each while it is held."""

from collections import deque

import numpy as np

from estimator.faults.fault import Fault, Tick
from estimator.record import Array

HELD_S, HELD_TICKS = 10.0, 5  # whichever is longer: then it is the sensor's own fault
EPISODES, EPISODES_S = 3, 300.0  # so many that ended by themselves are a loose contact
WILD = 3.0  # times its limit: further than any model is wrong, and counts twice
STILL, STUCK = 10, 20  # repeats


class Suspects:
    """How long each thermometer has been held, and how often before."""

    def __init__(self, m: int, begun_with: Array) -> None:
        """begun_with (m,) bool: what was not off from the start."""
        self._begun_with = begun_with
        self._ticks, self._first_s = np.zeros(m, dtype=int), np.full(m, np.nan)
        self._lowest, self._highest = np.full(m, np.inf), np.full(m, -np.inf)
        self._alone = np.zeros(m, dtype=bool)
        self._ended = [deque[float](maxlen=EPISODES) for _ in range(m)]

    def judged(self, tick: Tick, out: Array, held: Array, together: bool) -> dict[int, Fault]:
        """What becomes of thermometers that are `out` (m,) and of those that have been `held` (m,).

        together  whether most are out, which is no contact of one
        """
        self._alone = np.where(out, (self._alone | ~held) & (not together), self._alone)
        now = {i: self._ends(i, tick) for i in np.flatnonzero(held & tick.read & ~out).tolist()}
        return now | {i: self._goes_on(i, tick, begun=not held[i]) for i in np.flatnonzero(out).tolist()}

    def _goes_on(self, i: int, tick: Tick, begun: bool) -> Fault:
        if begun:
            self._ticks[i], self._first_s[i] = 0, tick.time_s
            self._lowest[i], self._highest[i] = np.inf, -np.inf
        self._ticks[i] += 1
        self._lowest[i] = min(self._lowest[i], tick.deviation[i])
        self._highest[i] = max(self._highest[i], tick.deviation[i])
        if not tick.beyond[i]:
            return Fault.STUCK if tick.repeats[i] >= STUCK else Fault.JUDGED
        if self._ticks[i] < HELD_TICKS or tick.time_s - self._first_s[i] < HELD_S:
            return Fault.JUDGED
        scattered = self._highest[i] - self._lowest[i] > 2.0 * tick.limit[i]
        if scattered:
            return Fault.LOOSE
        return Fault.JUMPED if self._begun_with[i] or tick.known[i] else Fault.OFF

    def _ends(self, i: int, tick: Tick) -> Fault:
        """It is back within the limit by itself."""
        ended, furthest = self._ended[i], max(-self._lowest[i], self._highest[i])
        if not self._alone[i]:
            return Fault.NONE
        ended.extend([tick.time_s] * (2 if furthest > WILD * tick.limit[i] else 1))
        return Fault.LOOSE if len(ended) == EPISODES and tick.time_s - ended[0] <= EPISODES_S else Fault.NONE
