"""Which view stands where: one tab for the summary, one for accuracy, and for each run what it looked like.

The limits of the time axes come from the data: left to itself a time series shows 30 s around the cursor.
"""

from __future__ import annotations

from collections.abc import Sequence

import rerun as rr
import rerun.blueprint as rrb

from estimator.rig import Rig
from viz import accuracy, paths, profile, screw
from viz.run import JUDGED, Run
from viz.scale import Range, Scale

LEGEND_ROOM = 1.6  # of the height: curves keep below the legend


def whole(extent: Range, room: float = 0.0) -> rrb.TimeAxis:
    """A time axis over a run; `room` is left at its end for a legend, as a share of the run."""
    absolute = rrb.TimeRangeBoundary.absolute
    end = extent[1] + room * (extent[1] - extent[0])
    return rrb.TimeAxis(view_range=rr.TimeRange(start=absolute(seconds=extent[0]), end=absolute(seconds=end)))


def blueprint(runs: Sequence[Run], scales: Sequence[Scale], tab: int | str = 0) -> rrb.Blueprint:
    """The layout of a saved file."""
    pages = [pages_of(paths.root(run.name), run.rig, scale) for run, scale in zip(runs, scales, strict=True)]
    judged = [run for run in runs if run.is_judged]
    common = [_summary(), *([_accuracy(accuracy.figure_of(judged).bounds)] if judged else [])]
    if len(runs) == 1:
        tabs = [*pages[0], *reversed(common)]
    else:
        tabs = [*common, *(rrb.Tabs(*some, name=run.name) for run, some in zip(runs, pages, strict=True))]
    return tabbed(tabs, tab)


def tabbed(tabs: Sequence[rrb.Container], tab: int | str = 0) -> rrb.Blueprint:
    """A layout of these tabs and nothing else."""
    return rrb.Blueprint(
        rrb.Tabs(*tabs, active_tab=tab),
        rrb.TimePanel(state="collapsed", timeline=paths.TIMELINE, play_state="following"),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        auto_views=False,
        auto_layout=False,
    )


def pages_of(root: str, rig: Rig, scale: Scale) -> list[rrb.Container]:
    """The tabs of one run."""
    return [_overview(root, rig, scale), _residuals(root, rig, scale), _channels(root, rig, scale)]


def _summary() -> rrb.Container:
    return rrb.Horizontal(rrb.TextDocumentView(origin=paths.SUMMARY, name="Summary"), name="Summary")


def _accuracy(bounds: tuple[Range, Range]) -> rrb.Container:
    figures = [
        flat(f"{paths.ACCURACY}/{estimate}", f"Accuracy of the {estimate}: reference over estimate [µm]", bounds)
        for estimate in JUDGED
    ]
    table = rrb.TextDocumentView(origin=paths.BANDS, name="Accuracy bands [µm]")
    return rrb.Horizontal(*figures, table, column_shares=[2, 2, 1.5], name="Accuracy")


def _overview(root: str, rig: Rig, scale: Scale) -> rrb.Container:
    curves: list[rrb.View] = [
        _below_legend(f"{root}/{paths.ELONGATION}", "Elongation [µm]", scale, scale.elongation_um)
    ]
    if scale.error_um:
        name = "Error: reference − estimate [µm]"
        curves.append(_below_legend(f"{root}/{paths.ERROR}", name, scale, scale.error_um))
    hidden = rrb.encodings.TimelineColumn(paths.TIMELINE, visible=False)  # the text says the time in full
    columns = rrb.TextLogColumns(timeline_columns=[hidden], text_log_columns=["LogLevel", "Body"])
    events = rrb.TextLogView(origin=f"{root}/{paths.EVENTS}", name="Events", columns=columns)
    right = rrb.Vertical(*curves, events, row_shares=[*(4, 3)[: len(curves)], 2])
    if rig.screw is None:
        return rrb.Horizontal(right, name="Overview")
    name = f"Temperature along the {_body(rig)} [°C over mm]"
    place = flat(f"{root}/{paths.PROFILE}", name, profile.axes_of(rig, scale).bounds)
    return rrb.Horizontal(rrb.Vertical(place, _screw(root, rig, scale), row_shares=[5, 4]), right, name="Overview")


def _body(rig: Rig) -> str:
    return "screw" if rig.nut else "body"


def _screw(root: str, rig: Rig, scale: Scale) -> rrb.Spatial3DView:
    assert rig.screw is not None
    middle, length = (rig.screw.from_mm + rig.screw.to_mm) / 2, rig.screw.to_mm - rig.screw.from_mm
    eye = rrb.EyeControls3D(
        position=[middle, -0.62 * length, 0.16 * length], look_target=[middle, 0, -0.06 * length], eye_up=[0, 0, 1]
    )
    return rrb.Spatial3DView(
        origin=f"{root}/{paths.SCREW}",
        name=f"{_body(rig).capitalize()}: temperature [°C] as colour, growth × {screw.exaggeration(rig, scale):g}",
        background=list(paths.BACKGROUND),
        line_grid=rrb.LineGrid3D(visible=False),
        eye_controls=eye,
    )


def _residuals(root: str, rig: Rig, scale: Scale) -> rrb.Container:
    rows = f"row = thermometer {rig.thermometers[0]} ... {rig.thermometers[-1]} from below"
    count = len(rig.thermometers)
    maps = [
        _map(root, paths.SURPRISE_MAP, paths.SURPRISE_BAR, f"Innovation, mean of 1 min [K]; {rows}", scale, count),
        _map(root, paths.MODEL_MAP, paths.MODEL_BAR, f"Measured − open-loop, mean of 1 min [K]; {rows}", scale, count),
    ]
    white = _plot(
        f"{root}/{paths.WHITENESS}",
        "Sum of a minute's innovations over its sd [1]; within ±1.96 if white",
        scale,
        None,
        False,
    )
    nis = _plot(f"{root}/{paths.NIS}", "NIS over its channels, mean of 1 min [1]", scale, None, room=0.3)
    return rrb.Vertical(*maps, rrb.Horizontal(white, nis), row_shares=[3, 3, 2.4], name="Residuals")


def _map(root: str, at: str, bar: str, name: str, scale: Scale, count: int) -> rrb.Container:
    rows = _plot(f"{root}/{at}", name, scale, (0.0, count + 1.0), False)
    bounds = rrb.VisualBounds2D(x_range=[-6, 36], y_range=[-7, 75])
    colours = rrb.Spatial2DView(
        origin=f"{root}/{bar}", name="[K]", visual_bounds=bounds, background=list(paths.BACKGROUND)
    )
    return rrb.Horizontal(rows, colours, column_shares=[9, 1])


def _channels(root: str, rig: Rig, scale: Scale) -> rrb.Container:
    plots = []
    for plot, columns in paths.thermometer_groups(rig).items():
        first, *_, last = [*rig.thermometers[columns]] * 2
        name = f"Thermometers {first} ... {last} [°C]"
        plots.append(_plot(f"{root}/{plot}", name, scale, scale.temperature_C, room=0.2))
    innovation = _plot(f"{root}/{paths.INNOVATIONS}", "Innovations of each tick [K]", scale, None, False)
    displacement = _plot(f"{root}/{paths.DISPLACEMENT}", "Innovations of the displacement [µm]", scale, None, False)
    return rrb.Vertical(*plots, rrb.Horizontal(innovation, displacement), name="Channels")


def _plot(
    origin: str, name: str, scale: Scale, extent: Range | None, legend: bool = True, room: float = 0.0
) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin=origin,
        name=name,
        axis_x=whole(scale.time_s, room),
        axis_y=rrb.ScalarAxis(range=extent, zoom_lock=False) if extent else None,
        plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.RightTop, visible=legend),
    )


def _below_legend(origin: str, name: str, scale: Scale, extent: Range) -> rrb.TimeSeriesView:
    """A plot whose curves keep below its legend."""
    return _plot(origin, name, scale, (extent[0], extent[0] + LEGEND_ROOM * (extent[1] - extent[0])))


def flat(origin: str, name: str, bounds: tuple[Range, Range]) -> rrb.Spatial2DView:
    """A figure drawn by hand."""
    x, y = bounds
    visible = rrb.VisualBounds2D(x_range=list(x), y_range=list(y))
    return rrb.Spatial2DView(origin=origin, name=name, visual_bounds=visible, background=list(paths.BACKGROUND))
