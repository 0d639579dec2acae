"""Which view of two models stands where: what holds for all recordings first, then each recording's own tabs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import rerun.blueprint as rrb

from viz.comparison import curves
from viz.comparison.compared import ComparedRun
from viz.comparison.maps import BODIES, BROUGHT, HEAT, INNOVATION, OPEN_LOOP, TITLES, UNITS, brings, frame_of, map_of
from viz.drawing import paths
from viz.drawing.bars import Bars
from viz.drawing.views import below_legend, by_run, ends, flat, key, paged, plot, summary_view, tabbed, whole

PLOTS = 4  # thermometers on one page
LEGEND_AT_END = 0.2  # of a plot's time


def blueprint(
    runs: Sequence[ComparedRun], models: Sequence[str], figures: Mapping[str, Sequence[Bars]]
) -> rrb.Blueprint:  # fmt: skip
    """The layout of a saved file."""
    first, *others = [_figures(tab, some) for tab, some in figures.items()]
    own = by_run([run.name for run in runs], [_pages(run, models) for run in runs])
    return tabbed([rrb.Horizontal(summary_view(), first, name="Summary"), *others, *own])


def bars_at(tab: str, i: int) -> str:
    """Where figure i of a tab is."""
    return f"{paths.BARS}/{paths.root(tab)}/{i}"


def _figures(tab: str, some: Sequence[Bars]) -> rrb.Container:
    drawn = [flat(bars_at(tab, i), each.title, each.frame.bounds) for i, each in enumerate(some)]
    return rrb.Vertical(*drawn, row_shares=[len(each.rows) + 5 for each in some], name=tab)


def _pages(run: ComparedRun, models: Sequence[str]) -> list[rrb.Container]:
    lengths = run.rig.screw is not None or not run.rig.is_thermometer.all()
    return [
        *_heat(run, models),
        rrb.Vertical(_maps(run, models, OPEN_LOOP), _maps(run, models, INNOVATION), name="Residuals"),
        *([_elongation(run)] if lengths else []),
        *(_temperatures(run, group) for group in paged(len(run.rig.thermometers), PLOTS)),
    ]


def titles(models: Sequence[str]) -> dict[str, str]:
    """What a view says of its model, by "before" and "after"."""
    if len(models) == 1:
        return {paths.SIDES[0]: models[0]}
    return {side: f"{side}: {name}" for side, name in zip(paths.SIDES, models, strict=True)}


def _heat(run: ComparedRun, models: Sequence[str]) -> list[rrb.Container]:
    heat, views = run.sides[0].heat, []
    if len(heat.places_mm):
        views.append(_maps(run, models, HEAT))
    if heat.bodies:
        name = f"Heat that the model alone lacks in {', '.join(heat.bodies)} [W]"
        views.append(plot(paths.compared(paths.root(run.name), BODIES), name, whole(run.time_s)))
    return [rrb.Vertical(*views, name="Missing heat")] if views else []


def _maps(run: ComparedRun, models: Sequence[str], what: str) -> rrb.Container:
    root, bounds = paths.root(run.name), frame_of(map_of(run, run.sides[0], what), what).bounds
    views = [
        flat(paths.compared(root, what, side), f"{title}: {TITLES[what]}", bounds)
        for side, title in titles(models).items()
    ]
    if what == HEAT and brings(run):
        views.append(flat(paths.compared(root, BROUGHT, list(run.named)[-1]), brings(run), bounds))
    shares = [*[9.0] * len(views), 1.9]
    return rrb.Horizontal(*views, key(paths.compared(root, f"{what}_key"), UNITS[what]), column_shares=shares)


def _elongation(run: ComparedRun) -> rrb.Container:
    root, span, views = paths.root(run.name), whole(run.time_s), []
    if run.rig.screw is not None:
        origin = paths.compared(root, "elongation")
        views.append(below_legend(origin, "Elongation [µm]", span, curves.elongation(run)))
    if not run.rig.is_thermometer.all():
        origin, name = (
            paths.compared(root, "displacement"),
            "Displacement reading − open-loop, unknown zero taken out [µm]",
        )
        views.append(below_legend(origin, name, span, curves.misfit(run)))
    return rrb.Vertical(*views, row_shares=[3, 2][: len(views)], name="Elongation")


def _temperatures(run: ComparedRun, group: range) -> rrb.Container:
    plots, names = [], paths.channel_names(run.rig, "°C")
    for i in group:
        channel = run.rig.thermometers[i]
        extent = curves.temperatures(run, run.rig.index(channel))
        origin = paths.compared(paths.root(run.name), "temperature", channel)
        plots.append(plot(origin, names[i], whole(run.time_s), extent, room=LEGEND_AT_END))
    name = ends([run.rig.thermometers[i] for i in group])
    return rrb.Grid(*plots, grid_columns=2 if len(group) > 1 else 1, name=name)
