"""By how much channels scatter from one reading to the next, where a model says by how much they should.

    w^2    median over the thermometers of mean((e_k - e_k-1)^2) / (2 variance), at least 1

What a model or an estimate is off by lasts: successive readings have it alike, and do not differ by it. What they
differ by is the sensors' own noise, and one that is broken does not move the median.
"""

from statistics import median

import numpy as np

from estimator.record import Array


class Scatter:
    """What m channels have differed by."""

    def __init__(self, which: Array) -> None:
        """which (m,) bool: those that are asked."""
        self._which, m = which, len(which)
        self._last, self._squares, self._pairs = np.full(m, np.nan), np.zeros(m), np.zeros(m)

    def hear(self, rows: Array) -> None:
        """Take ticks (K, m), NaN where nothing was read."""
        differ = np.diff(rows, axis=0, prepend=self._last[None]) ** 2 / 2.0
        self._squares += np.nansum(differ, axis=0)
        self._pairs += np.isfinite(differ).sum(axis=0)
        self._last = rows[-1]

    def times(self, variance: Array | float = 1.0) -> float:
        """w^2, where readings should scatter by `variance` (m,)."""
        asked = self._which & (self._pairs > 0)
        mean = self._squares / np.maximum(self._pairs, 1.0) / variance
        return max(1.0, median(mean[asked].tolist())) if asked.any() else 1.0

    def fade(self, kept: float) -> None:
        """Forget a part of all that was heard."""
        self._squares *= kept
        self._pairs *= kept

    def begin(self) -> None:
        """The next tick does not follow the last one."""
        self._last = np.full_like(self._last, np.nan)
