"""The map of autocorrelations: a row for each channel, its innovations against themselves some seconds later."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimator.record import Array
from viz.drawing.scale import Range, symmetric, ticks_of
from viz.figures.map import Map, Sheet
from viz.tuning.tuned import ScaledInnovations

PALE = 0.2  # the map's colours reach at least so far: smaller autocorrelations are often chance
VIEW = 670.0, 620.0  # points


def map_of(channels: Sequence[str], lags_s: Array, side: ScaledInnovations, extent: Range) -> Sheet:
    """The map of one side of a recording."""
    lags = ticks_of((0.0, float(lags_s[-1])), 7)
    ticks, texts = lags / (lags_s[1] - lags_s[0]) + 0.5, [f"{lag:g}" for lag in lags]
    drawn = Map(channels, np.empty(0), side.autocorrelation.T, ticks, texts, "lag [s]")
    return Sheet(drawn, extent, "", VIEW)


def shades_of(*autocorrelations: Array) -> Range:
    """Range of the map's colours: what holds 99 % of all but lag 0."""
    end = symmetric(np.concatenate([each[:, 1:].ravel() for each in autocorrelations]))[1]
    return -max(end, PALE), max(end, PALE)
