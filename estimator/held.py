"""A value that is late by a tick or two is still the one of before."""

from __future__ import annotations

import numpy as np

from estimator.record import Array

TICKS = 2


class Held:
    """Fills short gaps of a series with the value before them; carries it from call to call."""

    def __init__(self) -> None:
        self._before = np.full(TICKS, np.nan)

    def held(self, values: Array) -> Array:
        """The next values, (n,), in order: NaN only where nothing was known for longer than TICKS."""
        series = np.concatenate([self._before, values])
        self._before = series[-TICKS:].copy()
        filled = series.copy()
        for late in range(1, TICKS + 1):
            older = np.concatenate([np.full(late, np.nan), series[:-late]])
            filled = np.where(np.isfinite(filled), filled, older)
        return filled[TICKS:]
