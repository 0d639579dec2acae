"""Which view of a tuning stands where: figures of all recordings first, then each recording's own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun.blueprint as rrb

from viz.drawing import paths
from viz.drawing.bars import NisBars
from viz.drawing.scale import Range, symmetric
from viz.drawing.views import by_run, ends, flat, paged, plot, summary_view, tabbed, whole
from viz.tuning.autocorrelation import map_of
from viz.tuning.tuned import Tuning

ROWS = 4  # channels on one page


def blueprint(channels: Sequence[str], runs: Sequence[Tuning], nis: Sequence[NisBars]) -> rrb.Blueprint:
    """The layout of a saved file."""
    figures = [flat(f"{paths.BARS}/{i}", each.title, each.frame.bounds) for i, each in enumerate(nis)]
    own = by_run([run.name for run in runs], [_pages(channels, run) for run in runs])
    return tabbed([rrb.Horizontal(*figures, name="NIS"), *own, rrb.Horizontal(summary_view(), name="Summary")])


def _pages(channels: Sequence[str], run: Tuning) -> list[rrb.Container]:
    return [_maps(channels, run), *(_innovations(channels, run, group) for group in paged(len(channels), ROWS))]


def _maps(channels: Sequence[str], run: Tuning) -> rrb.Container:
    at = f"{paths.root(run.name)}/{paths.AUTOCORRELATION}"
    title = "Autocorrelation of the innovations"
    maps = [
        flat(f"{at}/{side}", f"{title} {side} [1]", map_of(channels, run.lags_s, one, (-1.0, 1.0)).bounds)
        for side, one in run.sides.items()
    ]
    return rrb.Horizontal(*maps, name="Autocorrelation")


def _innovations(channels: Sequence[str], run: Tuning, group: range) -> rrb.Container:
    rows = []
    for i in group:
        low, high = symmetric(np.stack([side.scaled[:, i] for side in run.sides.values()]))
        extent = min(low, -5.0), max(high, 5.0)
        rows.append(rrb.Horizontal(*(_innovation(run, side, channels[i], extent) for side in run.sides)))
    return rrb.Vertical(*rows, name=f"Innovations {ends([channels[i] for i in group])}")


def _innovation(run: Tuning, side: str, channel: str, extent: Range) -> rrb.TimeSeriesView:
    name = f"{channel} {side}: innovation over its sd [1], with ±2 and the mean of each minute"
    origin = f"{paths.root(run.name)}/{paths.scaled(side, channel)}"
    return plot(origin, name, whole(run.time_s), extent, legend=False)
