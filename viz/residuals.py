"""Where measurement and model part: maps of channel over time, and whether the innovations are as large as they claim.

Two maps, because each hides what the other shows: the innovation (against the filter, one tick ahead) and the open-loop
error (against the model that never sees a temperature).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
from scipy.stats import chi2

from estimator.record import Array
from viz import paths
from viz.axes import colour_bar
from viz.scale import DIVERGING, Range, coloured
from viz.series import channel_colours, lines

WINDOW_S = 60.0
STRIPE = 13.0  # screen points
CONFIDENCE = 0.95


def style_map(rec: rr.RecordingStream, at: str, bar: str, names: Sequence[str], extent: Range) -> None:
    """Log the looks of a map with a stripe for each channel, and its colour bar, once."""
    looks = rr.SeriesLines(
        names=list(names), widths=[STRIPE] * len(names), aggregation_policy="Off", interpolation_mode="StepAfter"
    )
    rec.log(at, looks, static=True)
    shades = coloured(np.linspace(*extent, 64), extent, DIVERGING)
    labels = [f"{value:+g} K" if value else "0 K" for value in np.linspace(*extent, 5)]
    colour_bar(rec, bar, shades, labels)


def send_map(rec: rr.RecordingStream, at: str, time_s: Array, means_K: Array, extent: Range) -> None:
    """Log n windows: begins (n,) s and means (n, m) K; the row of a channel is its number, 1 ... m."""
    n, m = means_K.shape
    rows = np.tile(np.arange(1.0, m + 1), (n, 1))
    shades = coloured(means_K, extent, DIVERGING).reshape(-1, 4)
    columns = [
        *rr.Scalars.columns(scalars=rows),
        *rr.SeriesLines.columns(colors=shades).partition(np.full(n, m)),
    ]
    rec.send_columns(at, indexes=[rr.TimeColumn(paths.TIMELINE, duration=time_s)], columns=columns)


def style_tests(rec: rr.RecordingStream, root: str, names: Sequence[str]) -> None:
    """Log the looks of the windowed innovations and of NIS, once."""
    lines(rec, f"{root}/{paths.WHITENESS}/channels", names, channel_colours(len(names)), 1.2, "MinMax")
    lines(rec, f"{root}/{paths.WHITENESS}/bounds", ["95 % if white", ""], [paths.BOUND] * 2, 1.0)
    lines(rec, f"{root}/{paths.NIS}/window", ["NIS / channels"], [paths.FILTER], 1.5, "Max")
    bounds = ["χ² bound, 97.5 %", "χ² bound, 2.5 %"]
    lines(rec, f"{root}/{paths.NIS}/bounds", bounds, [paths.BOUND] * 2, 1.0, "Off")


def windows(time_s: Array, values: Array) -> tuple[Array, Array]:
    """Sums over windows of a minute: middles (n,) s and sums (n, ...), not-known counting as nothing."""
    window = np.floor((time_s - time_s[0]) / WINDOW_S).astype(int)
    total = np.zeros((window[-1] + 1, *values.shape[1:]))
    np.add.at(total, window, np.nan_to_num(values))
    return time_s[0] + (np.arange(len(total)) + 0.5) * WINDOW_S, total


def whiteness(time_s: Array, innovation: Array, sd: Array) -> tuple[Array, Array]:
    """Sum of a minute's innovations over the sd that the sum has if they are white: middles (n,), (n, m).

    Standard normal if the filter is right; beyond +-1.96 for longer than a window or two it is not.
    """
    known = np.where(np.isfinite(innovation), sd, np.nan)
    middle, total = windows(time_s, innovation)
    variance = windows(time_s, known**2)[1]
    return middle, np.divide(total, np.sqrt(variance), out=np.full_like(total, np.nan), where=variance > 0)


def consistency(time_s: Array, nis: Array, channels: Array) -> tuple[Array, Array, Array]:
    """A minute's NIS over its number of channels: middles (n,), ratio (n,), bounds (n, 2); 1 if the filter is right."""
    known = np.isfinite(nis)
    middle, total = windows(time_s, np.where(known, nis, 0.0))
    count = windows(time_s, np.where(known, channels, 0.0))[1]
    some = count > 0
    tails = [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2]
    bounds = np.stack([chi2.ppf(tail, count[some]) / count[some] for tail in tails[::-1]], axis=-1)
    return middle[some], total[some] / count[some], bounds
