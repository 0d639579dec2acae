"""What a tuning is shown as: innovations of each recording before and after."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from estimator.record import Array


@dataclass(frozen=True)
class ScaledInnovations:
    """Of one recording under one model: over their sd (T, m), NaN where there is none; autocorrelation (m, lags)."""

    scaled: Array
    autocorrelation: Array


@dataclass(frozen=True)
class Tuning:
    """One recording of T ticks, before and after.

    name     shown as the title of its tab
    time_s   (T,) s;   lags_s   (lags,) s, of the autocorrelation, rising evenly from 0
    sides    "before" and "after"
    """

    name: str
    time_s: Array
    lags_s: Array
    sides: Mapping[str, ScaledInnovations]
