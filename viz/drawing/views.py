"""The views that layouts are put together from, saved or live.

Time axes show a whole run, or a window that slides along: left to itself a time series shows 30 s around the cursor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import rerun as rr
import rerun.blueprint as rrb

from estimator.rig import Rig
from viz.drawing import paths
from viz.drawing.scale import Range

LEGEND_ROOM = 1.6  # of the height: curves keep below the legend
SQUEEZED = (-6.0, 36.0), (-7.0, 75.0)  # bounds of a colour bar's view


class Span(Protocol):
    """What time axes show."""

    @property
    def queried(self) -> rrb.VisibleTimeRange | None:
        """Which data is asked for at all; None: what the axis shows."""

    def axis(self, room: float) -> rrb.TimeAxis:
        """The axis; `room` is left at its end for a legend, as a share of the span."""


@dataclass(frozen=True)
class Whole:
    """A run from its begin to its end, s."""

    extent: Range
    queried: None = None

    def axis(self, room: float) -> rrb.TimeAxis:
        """From begin to end."""
        return whole(self.extent, room)


@dataclass(frozen=True)
class Everything:
    """All there is, however long it has become."""

    queried: None = None

    def axis(self, room: float) -> rrb.TimeAxis:
        """From the first row to the last: an end that is not known leaves no room."""
        infinite = rrb.TimeRangeBoundary.infinite
        return rrb.TimeAxis(view_range=rr.TimeRange(start=infinite(), end=infinite()))


@dataclass(frozen=True)
class Sliding:
    """The last `window_s` s."""

    window_s: float

    @property
    def queried(self) -> rrb.VisibleTimeRange:
        """Nothing older than the window: what the viewer has to do does not grow with the run."""
        relative = rrb.TimeRangeBoundary.cursor_relative
        return rrb.VisibleTimeRange(paths.TIMELINE, start=relative(seconds=-self.window_s), end=relative(seconds=0.0))

    def axis(self, room: float) -> rrb.TimeAxis:
        """From the window's begin to now."""
        relative, after = rrb.TimeRangeBoundary.cursor_relative, max(room, 0.02) * self.window_s
        window = rr.TimeRange(start=relative(seconds=-self.window_s), end=relative(seconds=after))
        return rrb.TimeAxis(view_range=window)


def whole(extent: Range, room: float = 0.0) -> rrb.TimeAxis:
    """A time axis over a run; `room` is left at its end for a legend, as a share of the run."""
    absolute = rrb.TimeRangeBoundary.absolute
    end = extent[1] + room * (extent[1] - extent[0])
    return rrb.TimeAxis(view_range=rr.TimeRange(start=absolute(seconds=extent[0]), end=absolute(seconds=end)))


def plot(
    origin: str, name: str, span: Span, extent: Range | None = None, legend: bool = True, room: float = 0.0
) -> rrb.TimeSeriesView:
    """Curves over time; without an `extent` of their values the viewer chooses one."""
    return rrb.TimeSeriesView(
        origin=origin,
        name=name,
        axis_x=span.axis(room),
        axis_y=rrb.ScalarAxis(range=extent, zoom_lock=False) if extent else None,
        plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.RightTop, visible=legend),
        time_ranges=span.queried,
    )


def below_legend(origin: str, name: str, span: Span, extent: Range) -> rrb.TimeSeriesView:
    """A plot whose curves keep below its legend."""
    return plot(origin, name, span, (extent[0], extent[0] + LEGEND_ROOM * (extent[1] - extent[0])))


def flat(origin: str, name: str, bounds: tuple[Range, Range]) -> rrb.Spatial2DView:
    """A figure drawn by hand."""
    x, y = bounds
    visible = rrb.VisualBounds2D(x_range=list(x), y_range=list(y))
    return rrb.Spatial2DView(origin=origin, name=name, visual_bounds=visible, background=list(paths.BACKGROUND))


def profile_view(root: str, rig: Rig, bounds: tuple[Range, Range]) -> rrb.Spatial2DView:
    """The temperatures along the screw."""
    return flat(f"{root}/{paths.PROFILE}", f"Temperature along the {body(rig)} [°C over mm]", bounds)


def screw_view(root: str, rig: Rig, growth: str, distance: float = 0.62) -> rrb.Spatial3DView:
    """The screw in space, seen from a `distance` in lengths of it; `growth` says how that is drawn."""
    assert rig.screw is not None
    middle, length = (rig.screw.from_mm + rig.screw.to_mm) / 2, rig.screw.to_mm - rig.screw.from_mm
    eye = rrb.EyeControls3D(
        position=[middle, -distance * length, 0.16 * length], look_target=[middle, 0, -0.06 * length], eye_up=[0, 0, 1]
    )
    return rrb.Spatial3DView(
        origin=f"{root}/{paths.SCREW}",
        name=f"{body(rig).capitalize()}: temperature [°C] as colour, {growth}",
        background=list(paths.BACKGROUND),
        line_grid=rrb.LineGrid3D(visible=False),
        eye_controls=eye,
    )


def body(rig: Rig) -> str:
    """What the thing along x is called."""
    return "screw" if rig.nut else "body"


def events_view(root: str) -> rrb.TextLogView:
    """What happened, in words."""
    hidden = rrb.encodings.TimelineColumn(paths.TIMELINE, visible=False)  # the text says the time in full
    columns = rrb.TextLogColumns(timeline_columns=[hidden], text_log_columns=["LogLevel", "Body"])
    return rrb.TextLogView(origin=f"{root}/{paths.EVENTS}", name="Events", columns=columns)


def nis_view(root: str, span: Span) -> rrb.TimeSeriesView:
    """Whether the innovations are as large as the filter expects."""
    return plot(f"{root}/{paths.NIS}", "NIS over its channels, mean of 1 min [1]", span, room=0.3)


def residual_page(root: str, rig: Rig, span: Span) -> rrb.Container:
    """Where measurement and model part."""
    rows = f"row = thermometer {rig.thermometers[0]} ... {rig.thermometers[-1]} from below"
    count = len(rig.thermometers)
    maps = [
        _map(root, paths.SURPRISE_MAP, paths.SURPRISE_BAR, f"Innovation, mean of 1 min [K]; {rows}", span, count),
        _map(root, paths.MODEL_MAP, paths.MODEL_BAR, f"Measured − open-loop, mean of 1 min [K]; {rows}", span, count),
    ]
    name = "Sum of a minute's innovations over its sd [1]; within ±1.96 if white"
    white = plot(f"{root}/{paths.WHITENESS}", name, span, legend=False)
    return rrb.Vertical(*maps, rrb.Horizontal(white, nis_view(root, span)), row_shares=[3, 3, 2.4], name="Residuals")


def _map(root: str, at: str, bar: str, name: str, span: Span, count: int) -> rrb.Container:
    rows = plot(f"{root}/{at}", name, span, (0.0, count + 1.0), legend=False)
    return rrb.Horizontal(rows, flat(f"{root}/{bar}", "[K]", SQUEEZED), column_shares=[9, 1])


def channel_page(root: str, rig: Rig, span: Span, temperature_C: Range | None = None) -> rrb.Container:
    """What every channel reads, and how far it is from what was expected."""
    plots = temperature_plots(root, rig, span, temperature_C)
    innovation = plot(f"{root}/{paths.INNOVATIONS}", "Innovations of each tick [K]", span, legend=False)
    name = "Innovations of the displacement [µm]"
    displacement = plot(f"{root}/{paths.DISPLACEMENT}", name, span, legend=False)
    return rrb.Vertical(*plots, rrb.Horizontal(innovation, displacement), name="Channels")


def temperature_plots(root: str, rig: Rig, span: Span, temperature_C: Range | None = None) -> list[rrb.TimeSeriesView]:
    """What the thermometers read, in as few plots as leave every legend whole."""
    plots = []
    for at, columns in paths.thermometer_groups(rig).items():
        first, *_, last = [*rig.thermometers[columns]] * 2
        plots.append(plot(f"{root}/{at}", f"Thermometers {first} ... {last} [°C]", span, temperature_C, room=0.2))
    return plots


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
