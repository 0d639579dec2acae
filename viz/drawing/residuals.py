"""Where measurement and model part: maps of channel over time, and whether the innovations are as large as they claim.

Two maps, because each hides what the other shows: the innovation (against the filter, one tick ahead) and the open-loop
error (against the model that never sees a temperature).
"""

from dataclasses import dataclass

import numpy as np
import rerun as rr
import scipy

from estimator.faults.fault import Fault
from estimator.record import Array
from estimator.rig import Rig
from estimator.step import Track
from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.drawing.scale import DIVERGING, MINUTE_S, Range, coloured, sums
from viz.drawing.series import channel_colours

STRIPE = 13.0  # screen points
CONFIDENCE = 0.95
NIS = "NIS / channels", paths.FILTER
WHITE = 1.96  # sd that hold 95 %


@dataclass(frozen=True)
class Residuals:
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
    def of(cls, track: Track, heat: Array) -> "Residuals":
        """Ticks of a track; `heat` (m,) says which channels are thermometers. What is broken is not known."""
        well = (track.fault == Fault.NONE)[:, heat]
        innovation, apart = (
            np.where(well, a[:, heat], np.nan) for a in (track.innovation, track.measured - track.open_loop)
        )
        return cls(track.time_s, innovation, track.innovation_sd[:, heat], apart, track.nis, track.nis_channels)

    def mapped(self) -> dict[str, Array]:
        """What each map shows, (n, m) K."""
        return dict(zip(paths.MAPS, (self.innovation, self.open_loop), strict=True))


def send_map(at: Entity, time_s: Array, means_K: Array, extent: Range) -> None:
    """Log n windows: begins (n,) s and means (n, m) K; the row of a channel is its number, 1 ... m."""
    n, m = means_K.shape
    rows = np.tile(np.arange(1.0, m + 1), (n, 1))
    shades = coloured(means_K, extent, DIVERGING).reshape(-1, 4)
    colours = rr.SeriesLines.columns(colors=shades).partition(np.full(n, m))
    at.rows(time_s, [*rr.Scalars.columns(scalars=rows), *colours])


def style(at: Entity, rig: Rig) -> None:
    """Log the looks of both maps, of the windowed innovations and of NIS, once."""
    names, wide = paths.channel_names(rig, "K"), [STRIPE] * len(rig.thermometers)
    stripes = rr.SeriesLines(names=names, widths=wide, aggregation_policy="Off", interpolation_mode="StepAfter")
    for drawn in paths.MAPS:
        (at / drawn).log(stripes)
    names = paths.channel_names(rig, "1")
    (at / paths.WHITENESS / "channels").lines(names, channel_colours(len(names)), 1.2, "MinMax")
    (at / paths.WHITENESS / "bounds").lines(["95 % if white", ""], [paths.BOUND] * 2, 1.0)
    style_nis(at)


def style_nis(at: Entity) -> None:
    """Log the looks of NIS, once."""
    name, colour = NIS
    (at / paths.NIS / "window").lines([name], [colour], 1.5, "Max")
    bounds = ["χ² bound, 97.5 %", "χ² bound, 2.5 %"]
    (at / paths.NIS / "bounds").lines(bounds, [paths.BOUND] * 2, 1.0, "Off")


def send_tests(at: Entity, misfit: Residuals, first_s: float) -> None:
    """Log windowed innovations, between what they stay if they are white, and NIS of each minute from `first_s` on."""
    middle, white = whiteness(misfit.time_s, misfit.innovation, misfit.innovation_sd, first_s)
    (at / paths.WHITENESS / "channels").curves(middle, white)
    (at / paths.WHITENESS / "bounds").curves(middle, np.tile([WHITE, -WHITE], (len(middle), 1)))
    send_nis(at, misfit, first_s)


def send_nis(at: Entity, misfit: Residuals, first_s: float | None = None) -> None:
    """Log NIS of each minute from `first_s` on."""
    middle, ratio, bounds = consistency(misfit.time_s, misfit.nis, misfit.channels, first_s)
    (at / paths.NIS / "window").curves(middle, ratio)
    (at / paths.NIS / "bounds").curves(middle, bounds)


def whiteness(time_s: Array, innovation: Array, sd: Array, first_s: float | None = None) -> tuple[Array, Array]:
    """Sum of a minute's innovations over the sd that the sum has if they are white: middles (n,), (n, m).

    Standard normal if the filter is right; beyond +-1.96 for longer than a window or two it is not.
    """
    known = np.where(np.isfinite(innovation), sd, np.nan)
    begins, total = sums(time_s, innovation, first_s=first_s)
    variance = sums(time_s, known**2, first_s=first_s)[1]
    white = np.divide(total, np.sqrt(variance), out=np.full_like(total, np.nan), where=variance > 0)
    return begins + MINUTE_S / 2, white


def consistency(time_s: Array, nis: Array, channels: Array, first_s: float | None = None) -> tuple[Array, Array, Array]:
    """A minute's NIS over its number of channels: middles (n,), ratio (n,), bounds (n, 2); 1 if the filter is right."""
    begins, total = sums(time_s, nis, first_s=first_s)
    count = sums(time_s, np.where(np.isfinite(nis), channels, 0.0), first_s=first_s)[1]
    some = count > 0
    tails = [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2]
    bounds = np.stack([scipy.special.chdtri(count[some], tail) / count[some] for tail in tails], axis=-1)
    return begins[some] + MINUTE_S / 2, total[some] / count[some], bounds
