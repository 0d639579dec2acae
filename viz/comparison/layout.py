"""Which view of two models stands where: what holds for all recordings first, then each recording's own tabs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import rerun.blueprint as rrb

from viz.comparison import curves
from viz.comparison.bars import Bars, at
from viz.comparison.maps import BODIES, HEAT, INNOVATION, OPEN_LOOP, TITLES, UNITS, frame_of, map_of
from viz.drawing import paths
from viz.drawing.scale import Range, lasting
from viz.drawing.views import LEGEND_ROOM, SQUEEZED, Whole, flat, plot, tabbed

if TYPE_CHECKING:
    from viz.comparison.compared import Compared

PLOTS = 4  # thermometers on one page
LEGEND_AT_END = 0.2  # of a plot's time


def blueprint(
    runs: Sequence[Compared], models: Sequence[str], figures: Mapping[str, Sequence[Bars]]
) -> rrb.Blueprint:  # fmt: skip
    """The layout of a saved file."""
    pages = [_pages(run, models) for run in runs]
    own = (
        pages[0] if len(runs) == 1 else [rrb.Tabs(*some, name=run.name) for run, some in zip(runs, pages, strict=True)]
    )
    text = rrb.TextDocumentView(origin=paths.SUMMARY, name="Summary")
    first, *others = [_figures(tab, some) for tab, some in figures.items()]
    return tabbed([rrb.Horizontal(text, first, name="Summary"), *others, *own])


def _figures(tab: str, some: Sequence[Bars]) -> rrb.Container:
    drawn = [flat(at(tab, i), each.title, each.frame.bounds) for i, each in enumerate(some)]
    return rrb.Vertical(*drawn, row_shares=[len(each.rows) + 5 for each in some], name=tab)


def _pages(run: Compared, models: Sequence[str]) -> list[rrb.Container]:
    count = len(run.rig.thermometers)
    groups = [range(first, min(first + PLOTS, count)) for first in range(0, count, PLOTS)]
    return [
        *_heat(run, models),
        _residuals(run, models),
        *([_elongation(run)] if run.rig.screw is not None or len(run.lengths) else []),
        *(_temperatures(run, group) for group in groups),
    ]


def titles(models: Sequence[str]) -> dict[str, str]:
    """What a view says of its model, by "before" and "after"."""
    if len(models) == 1:
        return {paths.SIDES[0]: models[0]}
    return {side: f"{side}: {name}" for side, name in zip(paths.SIDES, models, strict=True)}


def _residuals(run: Compared, models: Sequence[str]) -> rrb.Container:
    return rrb.Vertical(_maps(run, models, OPEN_LOOP), _maps(run, models, INNOVATION), name="Residuals")


def _heat(run: Compared, models: Sequence[str]) -> list[rrb.Container]:
    heat, views = run.sides[0].heat, []
    if len(heat.places_mm):
        views.append(_maps(run, models, HEAT))
    if heat.bodies:
        name = f"Heat that the model alone lacks in {', '.join(heat.bodies)} [W]"
        views.append(_plot(run, paths.compared(paths.root(run.name), BODIES), name, None, True))
    return [rrb.Vertical(*views, name="Missing heat")] if views else []


def _maps(run: Compared, models: Sequence[str], what: str) -> rrb.Container:
    root, bounds = paths.root(run.name), frame_of(map_of(run, run.sides[0], what), what).bounds
    views = [
        flat(paths.compared(root, what, side), f"{title}: {TITLES[what]}", bounds)
        for side, title in titles(models).items()
    ]
    views.append(flat(paths.compared(root, f"{what}_key"), f"[{UNITS[what]}]", SQUEEZED))
    return rrb.Horizontal(*views, column_shares=[*[9] * len(models), 1.9])


def _elongation(run: Compared) -> rrb.Container:
    root, views = paths.root(run.name), []
    if run.rig.screw is not None:
        low, high = curves.elongation(run)
        extent = low, low + LEGEND_ROOM * (high - low)
        views.append(_plot(run, paths.compared(root, "elongation"), "Elongation [µm]", extent, True))
    if len(run.lengths):
        name, (low, high) = (
            "Displacement reading − open-loop, unknown zero taken out [µm]",
            curves.misfit(run),
        )
        extent = low, low + LEGEND_ROOM * (high - low)
        views.append(_plot(run, paths.compared(root, "displacement"), name, extent, True))
    return rrb.Vertical(*views, row_shares=[3, 2][: len(views)], name="Elongation")


def _temperatures(run: Compared, group: range) -> rrb.Container:
    plots, names = [], paths.channel_names(run.rig, "°C")
    for i in group:
        channel, extent = run.rig.thermometers[i], curves.temperatures(run, int(run.thermometers[i]))
        origin = paths.compared(paths.root(run.name), "temperature", channel)
        plots.append(_plot(run, origin, names[i], extent, True, LEGEND_AT_END))
    first, *_, last = [run.rig.thermometers[i] for i in group] * 2
    name = f"{first} ... {last}" if len(group) > 1 else first
    return rrb.Grid(*plots, grid_columns=2 if len(group) > 1 else 1, name=name)


def _plot(
    run: Compared, origin: str, name: str, extent: Range | None, legend: bool = False, room: float = 0.0
) -> rrb.TimeSeriesView:
    return plot(origin, name, Whole(lasting(run.time_s)), extent, legend, room)
