"""What tuning did to a filter's innovations: views before and after, side by side, in one .rrd file.

The innovations stand over their own sd, so that one scale suits every channel: 95 % of them belong between the lines at
+-2, and the mean of a minute belongs at 0.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rerun.blueprint as rrb

from estimator.record import Array
from viz.drawing import bars, paths
from viz.drawing.bars import NisBars
from viz.drawing.entity import Entity
from viz.drawing.file import distinct, saved
from viz.drawing.scale import MINUTE_S, Range, minutes, symmetric, ticks_of
from viz.drawing.views import by_run, ends, flat, paged, plot, summary_view, tabbed, whole
from viz.figures.map import Map, Sheet

PALE = 0.2  # the map's colours reach at least so far: smaller autocorrelations are often chance
VIEW = 670.0, 620.0  # points
ROWS = 4  # channels on one page


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


def save(path: Path, channels: Sequence[str], runs: Sequence[Tuning], nis: Sequence[NisBars], summary: str) -> None:
    """Write all runs into `path` (.rrd), with `summary` (markdown); m channels, by name; figures of all recordings."""
    runs = distinct(runs)
    extent = shades_of(*(side.autocorrelation for run in runs for side in run.sides.values()))
    name, last_s = "tuning: " + ", ".join(run.name for run in runs), max(run.time_s[-1] for run in runs)
    with saved(path, blueprint(channels, runs, nis), name, summary, float(np.floor(last_s))) as file:
        for i, each in enumerate(nis):
            bars.send(file / paths.BARS / str(i), each)
        for run in runs:
            at = file / paths.root(run.name)
            for side, one in run.sides.items():
                map_of(channels, run.lags_s, one, extent).send(at / paths.AUTOCORRELATION / side)
                for i, channel in enumerate(channels):
                    own = at / paths.scaled(side, channel)
                    _innovations(own, paths.COMPARED_AS[side], run.time_s, one.scaled[:, i])


def _innovations(at: Entity, colour: paths.Colour, time_s: Array, scaled: Array) -> None:
    """One channel's innovations, how they look and what they are."""
    (at / "each").dots("innovation / sd", colour, 0.8)
    (at / "each").known(time_s, scaled)
    (at / "mean").lines(["mean of a minute"], [paths.REFERENCE], 1.5)
    begins, means = minutes(time_s, scaled)
    (at / "mean").curves(begins + MINUTE_S / 2, means)
    (at / "bounds").lines(["±2 sd", ""], [paths.READING] * 2, 1.0, "Off")
    (at / "bounds").curves(time_s[[0, -1]], np.tile([2.0, -2.0], (2, 1)))


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


def blueprint(channels: Sequence[str], runs: Sequence[Tuning], nis: Sequence[NisBars]) -> rrb.Blueprint:
    """The layout of a saved file."""
    figures = [flat(f"{paths.BARS}/{i}", each.title, each.frame.bounds) for i, each in enumerate(nis)]
    own = by_run([run.name for run in runs], [_pages(channels, run) for run in runs])
    return tabbed([rrb.Horizontal(*figures, name="NIS"), *own, rrb.Horizontal(summary_view(), name="Summary")])


def _pages(channels: Sequence[str], run: Tuning) -> list[rrb.Container]:
    return [_maps(channels, run), *(_rows(channels, run, group) for group in paged(len(channels), ROWS))]


def _maps(channels: Sequence[str], run: Tuning) -> rrb.Container:
    at = f"{paths.root(run.name)}/{paths.AUTOCORRELATION}"
    title = "Autocorrelation of the innovations"
    maps = [
        flat(f"{at}/{side}", f"{title} {side} [1]", map_of(channels, run.lags_s, one, (-1.0, 1.0)).bounds)
        for side, one in run.sides.items()
    ]
    return rrb.Horizontal(*maps, name="Autocorrelation")


def _rows(channels: Sequence[str], run: Tuning, group: range) -> rrb.Container:
    rows = []
    for i in group:
        low, high = symmetric(np.stack([side.scaled[:, i] for side in run.sides.values()]))
        extent = min(low, -5.0), max(high, 5.0)
        rows.append(rrb.Horizontal(*(_view(run, side, channels[i], extent) for side in run.sides)))
    return rrb.Vertical(*rows, name=f"Innovations {ends([channels[i] for i in group])}")


def _view(run: Tuning, side: str, channel: str, extent: Range) -> rrb.TimeSeriesView:
    name = f"{channel} {side}: innovation over its sd [1], with ±2 and the mean of each minute"
    origin = f"{paths.root(run.name)}/{paths.scaled(side, channel)}"
    return plot(origin, name, whole(run.time_s), extent, legend=False)
