"""Readings that stand still: the same number again and again, from a channel whose readings used to jump about."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from estimator.record import Array

REPEATS = 20
STEPS = 2.0  # resolution steps from one reading to the next, on average: then 20 repeats have a chance of 1e-15
CHANGES = 20  # that must have been seen
SEEN = 200.0  # changes over which their size is forgotten


class Stuck:
    """How finely m channels resolve their own noise, and how long each has read the same.

    The resolution is the smallest change ever seen. A coarse sensor, whose readings change by one step or not at all,
    may well stand still: of it nothing can be said.
    """

    def __init__(self, m: int) -> None:
        self._last, self._finest = np.full(m, np.nan), np.full(m, np.inf)
        self._same, self._changes = np.zeros(m, dtype=int), np.zeros(m, dtype=int)
        self._size = np.zeros(m)

    def step(self, measured: Array) -> Iterator[tuple[int, float, int]]:
        """Take one tick, (m,), NaN where nothing was read: channels that are stuck, at what, for how many readings."""
        change = np.abs(measured - self._last)
        moved = change > 0
        self._finest[moved] = np.minimum(self._finest, change)[moved]
        self._changes += moved
        gain = 1.0 / np.minimum(np.maximum(self._changes, 1), SEEN)
        self._size[moved] += (gain * (change - self._size))[moved]
        self._same = np.where(change == 0, self._same + 1, np.where(moved, 0, self._same))
        self._last = np.where(np.isfinite(measured), measured, self._last)
        fine = (self._changes >= CHANGES) & (self._size >= STEPS * self._finest)
        for i in np.flatnonzero(fine & (self._same > REPEATS)):
            yield int(i), float(self._last[i]), int(self._same[i])
