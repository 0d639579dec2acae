"""Where measurement and model part: maps of channel over time, which channel surprises the filter most, and NIS.

Two maps, because each hides what the other shows: the innovation (against the filter, one tick ahead) and the open-loop
error (against the model that never sees a temperature).
"""

import numpy as np
import rerun.blueprint as rrb

from viz.drawing import bars, paths, residuals, views
from viz.drawing.bars import BarSeries, NisBars
from viz.drawing.entity import Entity
from viz.drawing.residuals import Residuals, consistency, whiteness
from viz.drawing.scale import Range, extent_of, rms
from viz.figures.map import Map, Sheet, means
from viz.recorded.run import ReviewedRun

MAP_VIEW = 480.0, 430.0  # points: two of them and the bars beside each other
BARS_WIDTH, BARS_LINE = 320, 44.0  # view units
NIS_SIZE = 0.5, 400.0  # share of the span that its legend takes, and length of its axis in points
TITLES = dict(zip(paths.MAPS, ("Innovation", "Measured − open-loop"), strict=True))


def send(at: Entity, run: ReviewedRun) -> None:
    """Log the maps of one run, the bars of its channels, and NIS of each minute."""
    for drawn, sheet in sheets(run).items():
        sheet.send(at / drawn)
    bars.send(at / paths.WHITENESS, surprises(run))
    residuals.style_nis(at)
    residuals.send_nis(at, _found(run))


def _found(run: ReviewedRun) -> Residuals:
    return Residuals.of(run.track, run.rig.is_thermometer)


def sheets(run: ReviewedRun) -> dict[str, Sheet]:
    """Both maps, each on a scale of its own: an innovation is a tenth of what the model alone misses."""
    extents = run.scale.innovation_K, run.scale.open_loop_K
    found = zip(_found(run).mapped().items(), extents, strict=True)
    return {
        drawn: Sheet(Map.over_time(run.rig.thermometers, *means(run.track.time_s, values)), extent, "K", MAP_VIEW)
        for (drawn, values), extent in found
    }


def surprises(run: ReviewedRun) -> NisBars:
    """rms of innovation over sd by channel, of each tick and of sums of a minute: 1 if the filter is right; the sums
    only if its innovations are white, too."""
    track, names = run.track, [name for name in run.rig.names if np.isfinite(run.nis_of[name])]
    each = np.sqrt([run.nis_of[name] for name in names])
    sums = rms(whiteness(track.time_s, np.where(track.fused, track.innovation, np.nan), track.innovation_sd)[1])
    series = [
        BarSeries("each tick", each, paths.FILTER),
        BarSeries("sum of 1 min", sums[[run.rig.index(name) for name in names]], paths.POLYLINE),
    ]
    worst = f"; worst {names[int(each.argmax())]}: {each.max():.2f}" if names else ""
    rows, title = names or ["none fused"], f"Innovation / sd, rms [1]{worst}"
    return NisBars(title, rows, series if names else [], BARS_WIDTH, BARS_LINE)


def _nis(run: ReviewedRun) -> Range:
    """Range of NIS over its channels."""
    found = _found(run)
    return 0.0, max(1.5, extent_of(consistency(found.time_s, found.nis, found.channels)[1])[1])


def page(root: str, run: ReviewedRun) -> rrb.Container:
    """The views that show it."""
    span, found = views.whole(run.track.time_s), surprises(run)
    maps = [views.flat(f"{root}/{at}", f"{TITLES[at]} [K]", one.bounds) for at, one in sheets(run).items()]
    surprise = views.flat(f"{root}/{paths.WHITENESS}", found.title, found.frame.bounds)
    above = rrb.Horizontal(*maps, surprise, column_shares=[5, 5, 4])
    nis = views.nis_view(root, span, _nis(run), *NIS_SIZE)
    below = rrb.Horizontal(views.state_view(root, span), views.channel_states(root, span), nis)
    return rrb.Vertical(above, below, row_shares=[7, 3], name="Residuals")
