"""What a tuning is shown as: innovations of each recording before and after."""

from __future__ import annotations

from dataclasses import dataclass

from estimator.record import Array


@dataclass(frozen=True)
class Side:
    """One recording under one model: innovations over their sd (T, m), NaN where there is none; their (m, lags)."""

    scaled: Array
    autocorrelation: Array


@dataclass(frozen=True)
class Tuning:
    """One recording of T ticks, before and after.

    name     shown as the title of its tab
    time_s   (T,) s;   lags_s   (lags,) s, of the autocorrelation, rising evenly from 0
    """

    name: str
    time_s: Array
    lags_s: Array
    before: Side
    after: Side
