"""Figures of a tuning that stand still: autocorrelation as a map of channel over lag, NIS as bars from 1.

Both are a picture with words around it; a view unit is a pixel of the picture, whose top left corner is (0, 0).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
from numpy.typing import ArrayLike

from estimator.record import Array
from viz.drawing import paths
from viz.drawing.axes import colour_bar, words
from viz.drawing.frame import LINE, ROW, WIDTH, Frame, places
from viz.drawing.scale import DIVERGING, Colours, Range, coloured, extent_of, symmetric, ticks_of

PALE = 0.2  # the map's colours reach at least so far: smaller autocorrelations are often chance
TICKS = np.array([m * 10.0**power for power in range(-3, 4) for m in (1, 2, 5)])


def frame_of_map(channels: Sequence[str], lags_s: Array) -> Frame:
    """The frame of a map: each lag is equally many pixels wide."""
    return Frame(len(lags_s) * max(1, round(WIDTH / len(lags_s))), channels)


def shades_of(*autocorrelations: Array) -> Range:
    """Range of the map's colours: what holds 99 % of all but lag 0."""
    end = symmetric(np.concatenate([each[:, 1:].ravel() for each in autocorrelations]))[1]
    return -max(end, PALE), max(end, PALE)


def send_map(
    rec: rr.RecordingStream, at: str, channels: Sequence[str], lags_s: Array, values: Array, extent: Range
) -> None:
    """Log autocorrelations (m, lags) as colours."""
    frame = frame_of_map(channels, lags_s)
    wide = frame.width // len(lags_s)
    shades = coloured(values, extent, DIVERGING)[..., :3]
    lags = ticks_of((0.0, float(lags_s[-1])), 7)
    x = wide * (lags / (lags_s[1] - lags_s[0]) + 0.5)
    frame.draw(rec, at, shades.repeat(ROW, axis=0).repeat(wide, axis=1), x, [f"{lag:g}" for lag in lags])
    words(rec, f"{at}/title", places([frame.width / 2], frame.height + 1.7 * LINE), ["lag [s]"])


def send_key(rec: rr.RecordingStream, at: str, extent: Range) -> None:
    """Log what the map's colours mean."""
    labels = [f"{value:+.2g}" if value else "0" for value in np.linspace(*extent, 5)]
    colour_bar(rec, at, coloured(np.linspace(*extent, 64), extent, DIVERGING), labels)


def frame_of_bars(channels: Sequence[str]) -> Frame:
    """The frame of bars."""
    return Frame(WIDTH, channels)


def send_bars(rec: rr.RecordingStream, at: str, channels: Sequence[str], before: Array, after: Array) -> None:
    """Log two bars for each channel from 1 to its NIS (m,), NaN: none; on a log scale half is as far off as twice."""
    frame, ticks = frame_of_bars(channels), ticks_of_bars(before, after)
    frame.draw(rec, at, _bars(frame, ticks, before, after), _across(ticks, ticks), [f"{tick:g}" for tick in ticks])
    for name, values, colour in (("grid", ticks, paths.GRID), ("right", [1.0], paths.READING)):
        upright = [places([x, x], [0, frame.height]) for x in _across(values, ticks)]
        strips = rr.LineStrips2D(upright, radii=rr.Radius.ui_points(0.6), colors=colour, draw_order=5.0)
        rec.log(f"{at}/{name}", strips, static=True)
    texts, colours = ["before", "after", "1: the noise is right"], [paths.BEFORE, paths.AFTER, paths.READING]
    words(rec, f"{at}/key", places(WIDTH * np.array([0.1, 0.3, 0.6]), -1.8 * LINE), texts, colours)


def ticks_of_bars(before: Array, after: Array) -> Array:
    """Ticks of the log scale, the first and the last at its ends."""
    lo, hi = extent_of(np.clip([before, after], TICKS[0], TICKS[-1]), np.array([0.5, 2.0]))
    first, last = np.flatnonzero(lo * 1.001 >= TICKS)[-1], np.flatnonzero(hi <= 1.001 * TICKS)[0]
    return TICKS[first : last + 1]


def _across(values: ArrayLike, ticks: Array) -> Array:
    """Where values stand, pixels from the left."""
    inside = np.clip(values, ticks[0], ticks[-1])
    return WIDTH * np.log(inside / ticks[0]) / np.log(ticks[-1] / ticks[0])


def _bars(frame: Frame, ticks: Array, before: Array, after: Array) -> Colours:
    """Pixels (height, width, 3)."""
    pixels = np.full((frame.height, frame.width, 3), paths.BACKGROUND, dtype=np.uint8)
    for values, top, colour in ((before, 7, paths.BEFORE), (after, ROW // 2, paths.AFTER)):
        for row in np.flatnonzero(np.isfinite(values)):
            left, right = np.sort(_across([1.0, values[row]], ticks)).round().astype(int)
            pixels[row * ROW + top : row * ROW + top + ROW // 2 - 7, left : right + 1] = colour
    return pixels
