"""Readings that stand still: the same number again and again, from a channel whose readings used to differ."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from estimator.record import Array

CHANCE = 1e-9  # of so many repeats in a row, if the channel goes on as it has
LEAST = 20
SEEN = 100.0  # readings over which the share of repeats is forgotten


class Stuck:
    """How often m channels repeat themselves, and how long each has been doing so.

    A coarse sensor repeats itself most of the time: with a share r of repeats so far, n in a row have the chance r^n.
    """

    def __init__(self, m: int) -> None:
        self._last = np.full(m, np.nan)
        self._same = np.zeros(m, dtype=int)
        self._share = np.full(m, 1.0)  # nothing is known of a channel before it has changed

    def step(self, measured: Array) -> Iterator[tuple[int, int]]:
        """Take one tick, (m,) with NaN where nothing was read: channels that are stuck, and for how many ticks."""
        known = np.isfinite(measured)
        same = known & (measured == self._last)
        changed = known & ~same & np.isfinite(self._last)
        # a stretch of repeats counts once it is over: a channel that is stuck must not become one that repeats itself
        self._share[changed] += (self._same[changed] / (self._same[changed] + 1.0) - self._share[changed]) * np.minimum(
            (self._same[changed] + 1.0) / SEEN, 1.0
        )
        self._same = np.where(same, self._same + 1, np.where(known, 0, self._same))
        self._last = np.where(known, measured, self._last)
        with np.errstate(divide="ignore"):
            most = np.log(CHANCE) / np.log(np.clip(self._share, 1e-3, 1.0))
        for i in np.flatnonzero(self._same > np.maximum(most, LEAST)):
            yield int(i), int(self._same[i])
