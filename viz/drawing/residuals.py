"""Where measurement and model part: maps of channel over time, and whether the innovations are as large as they claim.

Two maps, because each hides what the other shows: the innovation (against the filter, one tick ahead) and the open-loop
error (against the model that never sees a temperature).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr
from scipy.stats import chi2

from estimator.record import Array
from estimator.rig import Rig
from estimator.step import Track
from viz.drawing import paths
from viz.drawing.axes import colour_bar
from viz.drawing.columns import Indices
from viz.drawing.scale import DIVERGING, Range, coloured
from viz.drawing.series import channel_colours, lines, send

WINDOW_S = 60.0
STRIPE = 13.0  # screen points
CONFIDENCE = 0.95
NIS = "NIS / channels", paths.FILTER
WHITE = 1.96  # sd that hold 95 %
MAPS = {paths.SURPRISE_MAP: paths.SURPRISE_BAR, paths.MODEL_MAP: paths.MODEL_BAR}  # and the colour bar of each


@dataclass(frozen=True)
class Misfit:
    """How far thermometers are from what was expected of them, at n ticks.

    innovation, innovation_sd, open_loop   (n, m) K: against the filter, its sd, and against the model alone
    nis, channels                          (n,) of the whole filter
    """

    time_s: Array
    innovation: Array
    innovation_sd: Array
    open_loop: Array
    nis: Array
    channels: Array

    @classmethod
    def of(cls, track: Track, heat: Indices) -> Misfit:
        """Ticks of a track; `heat` are the columns of the thermometers."""
        apart = (track.measured - track.open_loop)[:, heat]
        scatter = track.innovation[:, heat], track.innovation_sd[:, heat]
        return cls(track.time_s, *scatter, apart, track.nis, track.nis_channels)

    def mapped(self) -> dict[str, Array]:
        """What each map shows, (n, m) K."""
        return dict(zip(MAPS, (self.innovation, self.open_loop), strict=True))


def _style_map(rec: rr.RecordingStream, at: str, names: Sequence[str]) -> None:
    """Log the looks of a map with a stripe for each channel, once."""
    looks = rr.SeriesLines(
        names=list(names), widths=[STRIPE] * len(names), aggregation_policy="Off", interpolation_mode="StepAfter"
    )
    rec.log(at, looks, static=True)


def map_bar(rec: rr.RecordingStream, at: str, extent: Range) -> None:
    """Log the colour bar of a map, once."""
    shades = coloured(np.linspace(*extent, 64), extent, DIVERGING)
    labels = [f"{value:+g} K" if value else "0 K" for value in np.linspace(*extent, 5)]
    colour_bar(rec, at, shades, labels)


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


def style(rec: rr.RecordingStream, root: str, rig: Rig) -> None:
    """Log the looks of both maps, of the windowed innovations and of NIS, once."""
    for at in MAPS:
        _style_map(rec, f"{root}/{at}", paths.channel_names(rig, "K"))
    names = paths.channel_names(rig, "1")
    lines(rec, f"{root}/{paths.WHITENESS}/channels", names, channel_colours(len(names)), 1.2, "MinMax")
    lines(rec, f"{root}/{paths.WHITENESS}/bounds", ["95 % if white", ""], [paths.BOUND] * 2, 1.0)
    name, colour = NIS
    lines(rec, f"{root}/{paths.NIS}/window", [name], [colour], 1.5, "Max")
    bounds = ["χ² bound, 97.5 %", "χ² bound, 2.5 %"]
    lines(rec, f"{root}/{paths.NIS}/bounds", bounds, [paths.BOUND] * 2, 1.0, "Off")


def send_tests(rec: rr.RecordingStream, root: str, misfit: Misfit, first_s: float | None = None) -> None:
    """Log windowed innovations and NIS of each minute from `first_s` on."""
    middle, white = whiteness(misfit.time_s, misfit.innovation, misfit.innovation_sd, first_s)
    send(rec, f"{root}/{paths.WHITENESS}/channels", middle, white)
    middle, ratio, bounds = consistency(misfit.time_s, misfit.nis, misfit.channels, first_s)
    send(rec, f"{root}/{paths.NIS}/window", middle, ratio)
    send(rec, f"{root}/{paths.NIS}/bounds", middle, bounds)


def send_bounds(rec: rr.RecordingStream, root: str, time_s: Array) -> None:
    """Log between what windowed innovations stay if they are white, at times (n,) s."""
    send(rec, f"{root}/{paths.WHITENESS}/bounds", time_s, np.tile([WHITE, -WHITE], (len(time_s), 1)))


def windows(time_s: Array, values: Array, first_s: float | None = None) -> tuple[Array, Array]:
    """Sums over windows of a minute: middles (n,) s and sums (n, ...), not-known counting as nothing.

    The first window begins at `first_s`, by default at the first time.
    """
    first_s = float(time_s[0]) if first_s is None else first_s
    window = np.floor((time_s - first_s) / WINDOW_S).astype(int)
    total = np.zeros((window[-1] + 1, *values.shape[1:]))
    np.add.at(total, window, np.nan_to_num(values))
    return first_s + (np.arange(len(total)) + 0.5) * WINDOW_S, total


def whiteness(time_s: Array, innovation: Array, sd: Array, first_s: float | None = None) -> tuple[Array, Array]:
    """Sum of a minute's innovations over the sd that the sum has if they are white: middles (n,), (n, m).

    Standard normal if the filter is right; beyond +-1.96 for longer than a window or two it is not.
    """
    known = np.where(np.isfinite(innovation), sd, np.nan)
    middle, total = windows(time_s, innovation, first_s)
    variance = windows(time_s, known**2, first_s)[1]
    return middle, np.divide(total, np.sqrt(variance), out=np.full_like(total, np.nan), where=variance > 0)


def consistency(time_s: Array, nis: Array, channels: Array, first_s: float | None = None) -> tuple[Array, Array, Array]:
    """A minute's NIS over its number of channels: middles (n,), ratio (n,), bounds (n, 2); 1 if the filter is right."""
    known = np.isfinite(nis)
    middle, total = windows(time_s, np.where(known, nis, 0.0), first_s)
    count = windows(time_s, np.where(known, channels, 0.0), first_s)[1]
    some = count > 0
    tails = [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2]
    bounds = np.stack([chi2.ppf(tail, count[some]) / count[some] for tail in tails[::-1]], axis=-1)
    return middle[some], total[some] / count[some], bounds
