"""Which view of a tuning stands where: figures of all recordings first, then each recording's own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import rerun.blueprint as rrb

from viz.drawing import paths
from viz.drawing.scale import lasting, symmetric
from viz.drawing.views import SQUEEZED, Whole, flat, plot, tabbed
from viz.tuning.figures import frame_of_bars, frame_of_map

if TYPE_CHECKING:
    from viz.tuning.tuned import Tuning

ROWS = 4  # channels on one page
SIDES = ("before", "after")


def blueprint(channels: Sequence[str], runs: Sequence[Tuning], bars: Sequence[str]) -> rrb.Blueprint:
    """The layout of a saved file; bars: titles of the figures of all recordings together."""
    pages = [_pages(channels, run) for run in runs]
    own = (
        pages[0] if len(runs) == 1 else [rrb.Tabs(*some, name=run.name) for run, some in zip(runs, pages, strict=True)]
    )
    bounds = frame_of_bars(channels).bounds
    figures = [flat(f"{paths.BARS}/{i}", title, bounds) for i, title in enumerate(bars)]
    summary = rrb.Horizontal(rrb.TextDocumentView(origin=paths.SUMMARY, name="Summary"), name="Summary")
    return tabbed([rrb.Horizontal(*figures, name="NIS"), *own, summary])


def _pages(channels: Sequence[str], run: Tuning) -> list[rrb.Container]:
    groups = [range(first, min(first + ROWS, len(channels))) for first in range(0, len(channels), ROWS)]
    return [_maps(channels, run), *(_innovations(channels, run, group) for group in groups)]


def _maps(channels: Sequence[str], run: Tuning) -> rrb.Container:
    at, bounds = f"{paths.root(run.name)}/{paths.AUTOCORRELATION}", frame_of_map(channels, run.lags_s).bounds
    maps = [flat(f"{at}/{side}", f"Autocorrelation of the innovations {side} [1]", bounds) for side in SIDES]
    key = flat(f"{at}/key", "[1]", SQUEEZED)
    return rrb.Horizontal(*maps, key, column_shares=[9, 9, 1.2], name="Autocorrelation")


def _innovations(channels: Sequence[str], run: Tuning, group: range) -> rrb.Container:
    rows = []
    for i in group:
        extent = symmetric(np.stack([run.before.scaled[:, i], run.after.scaled[:, i]]))
        views = [_innovation(run, side, channels[i], (min(extent[0], -5.0), max(extent[1], 5.0))) for side in SIDES]
        rows.append(rrb.Horizontal(*views))
    first, *_, last = [channels[i] for i in group] * 2
    return rrb.Vertical(*rows, name=f"Innovations {first}" + (f" ... {last}" if len(group) > 1 else ""))


def _innovation(run: Tuning, side: str, channel: str, extent: tuple[float, float]) -> rrb.TimeSeriesView:
    name = f"{channel} {side}: innovation over its sd [1], with ±2 and the mean of each minute"
    origin = paths.scaled(paths.root(run.name), side, channel)
    return plot(origin, name, Whole(lasting(run.time_s)), extent, legend=False)
