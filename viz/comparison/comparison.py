"""What one or two models say of recordings, before and after a change, beside each other: one .rrd file.

Curves are means of ten seconds: a model alone is smooth, and two models on hours of ticks would be a heavy file.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import rerun.blueprint as rrb

from viz.comparison import curves, heat, maps
from viz.comparison.compared import ComparedRun
from viz.comparison.maps import AFTER_ALONE, BODIES, HEAT, INNOVATION, OPEN_LOOP, SAID, UNITS, brings
from viz.drawing import bars, paths
from viz.drawing.bars import Bars
from viz.drawing.file import distinct, saved
from viz.drawing.scale import Range
from viz.drawing.views import below_legend, by_run, ends, flat, paged, plot, summary_view, tabbed, whole

Scales = Mapping[str, Range]  # of the colours of each kind of map
PLOTS = 4  # thermometers on one page
LEGEND_AT_END = 0.2  # of a plot's time


def save(
    path: Path, runs: Sequence[ComparedRun], models: Sequence[str], figures: Mapping[str, Sequence[Bars]], summary: str
) -> None:  # fmt: skip
    """Write all runs into `path` (.rrd) with `summary` (markdown); models by name.

    figures  of all runs, by the name of their tab; those of the first stand beside the summary
    """
    runs = distinct(runs)
    scales, last_s = maps.scales_of(runs), float(np.floor(max(run.time_s[-1] for run in runs)))
    name = f"{' and '.join(models)}: {', '.join(run.name for run in runs)}"
    with saved(path, blueprint(runs, models, figures, scales), name, summary, last_s) as file:
        for tab, some in figures.items():
            for i, each in enumerate(some):
                bars.send(file / bars_at(tab, i), each)
        for run in runs:
            curves.send(file, run)
            at = file / paths.compared(paths.root(run.name))
            for what in (maps.HEAT, maps.OPEN_LOOP, maps.INNOVATION):
                maps.send(at, run, what, scales[what])
            maps.send_bodies(at, run)
            heat.send(at, run)


def blueprint(
    runs: Sequence[ComparedRun], models: Sequence[str], figures: Mapping[str, Sequence[Bars]], scales: Scales
) -> rrb.Blueprint:
    """The layout of a saved file."""
    first, *others = [_figures(tab, some) for tab, some in figures.items()]
    own = by_run([run.name for run in runs], [_pages(run, models, scales) for run in runs])
    return tabbed([rrb.Horizontal(summary_view(), first, name="Summary"), *others, *own])


def bars_at(tab: str, i: int) -> str:
    """Where figure i of a tab is."""
    return f"{paths.BARS}/{paths.root(tab)}/{i}"


def _figures(tab: str, some: Sequence[Bars]) -> rrb.Container:
    drawn = [flat(bars_at(tab, i), each.title, each.frame.bounds) for i, each in enumerate(some)]
    return rrb.Vertical(*drawn, row_shares=[len(each.rows) + 5 for each in some], name=tab)


def _pages(run: ComparedRun, models: Sequence[str], scales: Scales) -> list[rrb.Container]:
    lengths = run.rig.screw is not None or not run.rig.is_thermometer.all()
    return [
        *_heat(run, models, scales),
        rrb.Vertical(*(_maps(run, models, what, scales) for what in (OPEN_LOOP, INNOVATION)), name="Residuals"),
        *([_elongation(run)] if lengths else []),
        *(_temperatures(run, group) for group in paged(len(run.rig.thermometers), PLOTS)),
    ]


def titles(models: Sequence[str]) -> dict[str, str]:
    """What a view says of its model, by "before" and "after"."""
    if len(models) == 1:
        return {paths.SIDES[0]: models[0]}
    return {side: f"{side}: {name}" for side, name in zip(paths.SIDES, models, strict=True)}


def _heat(run: ComparedRun, models: Sequence[str], scales: Scales) -> list[rrb.Container]:
    lacks, rows = run.sides[0].heat, list[Any]()
    if len(lacks.places_mm):
        rows += [rrb.Horizontal(*heat.views(run, models)), _maps(run, models, HEAT, scales)]
    if lacks.bodies:
        name = f"Heat that the model alone lacks in {', '.join(lacks.bodies)} [W]"
        rows.append(plot(paths.compared(paths.root(run.name), BODIES), name, whole(run.time_s), maps.bodies(run)))
    return [rrb.Vertical(*rows, name="Missing heat")] if rows else []


def _maps(run: ComparedRun, models: Sequence[str], what: str, scales: Scales) -> rrb.Container:
    root = paths.compared(paths.root(run.name))
    names = {f"{what}/{side}": f"{side}: {SAID[what]}, {model}" for side, model in zip(run.named, models, strict=True)}
    if len(models) == 1:
        names = {f"{what}/{paths.SIDES[0]}": f"{SAID[what]}, {models[0]}"}
    names[f"{what}/{AFTER_ALONE}"] = f"after, own scale [{UNITS[what]}]"
    found = maps.sheets(run, what, scales[what])
    return rrb.Horizontal(*(flat(f"{root}/{at}", names.get(at, brings(run)), one.bounds) for at, one in found.items()))


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
