"""Figures of a tuning that stand still: autocorrelation as a map of channel over lag, NIS as bars from 1."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr

from estimator.record import Array
from viz import paths
from viz.axes import Axes, colour_bar, words
from viz.scale import DIVERGING, Range, coloured, symmetric, ticks_of

ROW, WIDTH, LINE = 40.0, 900.0, 30.0  # view units: height of a channel, width of a frame, height of a line of text
PALE = 0.2  # autocorrelations below are chance more often than not: the map's colours begin no lower
NIS_TICKS = np.array([0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000])


def shades_of(*autocorrelations: Array) -> Range:
    """Range of the map's colours: what holds 99 % of all but lag 0."""
    end = symmetric(np.concatenate([each[:, 1:].ravel() for each in autocorrelations]))[1]
    return -max(end, PALE), max(end, PALE)


def axes_of_map(lags_s: Array, count: int) -> Axes:
    """The frame of a map, around the picture's pixels; lag 0 takes the first column."""
    half, high = (lags_s[1] - lags_s[0]) / 2, ROW * count
    extent = float(lags_s[0] - half), float(lags_s[-1] + half)
    return Axes(extent, (0.0, float(count)), float(_wide(lags_s) * len(lags_s)), high, LINE, down=high)


def _wide(lags_s: Array) -> int:
    """Pixels of one lag."""
    return max(1, round(WIDTH / len(lags_s)))


def send_map(
    rec: rr.RecordingStream, at: str, channels: Sequence[str], lags_s: Array, values: Array, extent: Range
) -> None:
    """Log autocorrelations (m, lags) as colours, the first channel at the top."""
    axes = axes_of_map(lags_s, len(channels))
    shades = coloured(values, extent, DIVERGING)[..., :3]
    pixels = shades.repeat(int(ROW), axis=0).repeat(_wide(lags_s), axis=1)
    rec.log(f"{at}/picture", rr.Image(pixels, magnification_filter="Nearest"), static=True)
    lags = ticks_of(axes.x, 7)
    words(rec, f"{at}/lags", axes.place(lags, 0.0) + [0.0, 0.2 * LINE], [f"{lag:g}" for lag in lags])
    words(rec, f"{at}/title", axes.place([sum(axes.x) / 2], 0.0) + [0.0, 1.7 * LINE], ["lag [s]"])
    _names(rec, at, axes, channels)


def send_bar(rec: rr.RecordingStream, at: str, extent: Range) -> None:
    """Log what the map's colours mean."""
    labels = [f"{value:+.2g}" if value else "0" for value in np.linspace(*extent, 5)]
    colour_bar(rec, at, coloured(np.linspace(*extent, 64), extent, DIVERGING), labels)


def axes_of_bars(before: Array, after: Array) -> Axes:
    """The frame of the bars, x as the logarithm: half of what is right is as far off as twice."""
    values = np.concatenate([before, after])
    values = np.log10(np.clip(values[np.isfinite(values)], NIS_TICKS[0], NIS_TICKS[-1]))
    lo, hi = (values.min(), values.max()) if len(values) else (0.0, 0.0)
    ticks = np.log10(NIS_TICKS)
    left, right = ticks[ticks <= min(lo, np.log10(0.5)) + 1e-9][-1], ticks[ticks >= max(hi, np.log10(2)) - 1e-9][0]
    return Axes((float(left), float(right)), (0.0, float(len(before))), WIDTH, ROW * len(before), LINE)


def send_bars(
    rec: rr.RecordingStream, at: str, axes: Axes, channels: Sequence[str], before: Array, after: Array
) -> None:
    """Log two bars for each channel, from 1 to its NIS, the first channel at the top."""
    ticks = NIS_TICKS[(np.log10(NIS_TICKS) >= axes.x[0] - 1e-9) & (np.log10(NIS_TICKS) <= axes.x[1] + 1e-9)]
    grid = [axes.place([x, x], axes.y) for x in np.log10(ticks)]
    thin = rr.Radius.ui_points(0.5)
    rec.log(f"{at}/grid", rr.LineStrips2D(grid, radii=thin, colors=paths.GRID, draw_order=-10.0), static=True)
    right = rr.LineStrips2D([axes.place([0, 0], axes.y)], radii=rr.Radius.ui_points(1), colors=paths.READING)
    rec.log(f"{at}/right", right, static=True)
    for name, values, shift, colour in (("before", before, 0.7, paths.BEFORE), ("after", after, 0.3, paths.AFTER)):
        known = np.flatnonzero(np.isfinite(values))
        ends = np.clip(np.log10(np.maximum(values[known], 1e-9)), *axes.x)
        levels = len(channels) - 1 - known + shift
        strips = [axes.place([0.0, end], level) for end, level in zip(ends, levels, strict=True)]
        rec.log(f"{at}/{name}", rr.LineStrips2D(strips, radii=0.16 * ROW, colors=colour), static=True)
    words(rec, f"{at}/ticks", axes.place(np.log10(ticks), 0.0) + [0.0, 0.2 * LINE], [f"{x:g}" for x in ticks])
    axes.key(
        rec, f"{at}/key", [("before", paths.BEFORE), ("after", paths.AFTER), ("1: as it should be", paths.READING)]
    )
    _names(rec, at, axes, channels)


def _names(rec: rr.RecordingStream, at: str, axes: Axes, channels: Sequence[str]) -> None:
    levels = len(channels) - 0.5 - np.arange(len(channels))
    words(rec, f"{at}/channels", axes.place(axes.x[0], levels) - [0.07 * WIDTH, 0.56 * LINE], channels)
