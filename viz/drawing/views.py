"""The views that layouts are put together from, saved or live.

Time axes show a whole run, or a window that slides along: left to itself a time series shows 30 s around the cursor.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import rerun as rr
import rerun.blueprint as rrb

from estimator.record import Array
from estimator.rig import Rig
from viz.drawing import paths
from viz.drawing.scale import Range, labelled, labelled_until

LEGEND_ROOM = 1.6  # of the height: curves keep below the legend
BESIDE_LEGEND = 0.36  # of the span, right of the curves
LOW, WIDE = 70.0, 600.0  # points, height of an axis that has little room, and length of one in half a window
SQUEEZED = (-6.0, 36.0), (-7.0, 75.0)  # bounds of a colour bar's view


@dataclass(frozen=True)
class Span:
    """What time axes show: from `begin_s` to `end_s`, measured as `boundary` says.

    slides  no older data is asked for: what the viewer has to do does not grow with the run
    """

    boundary: Callable[..., rrb.TimeRangeBoundary]
    begin_s: float = 0.0
    end_s: float = 0.0
    slides: bool = False

    def axis(self, room: float, width: float = WIDE) -> rrb.TimeAxis:
        """The axis, `width` points long; `room` is left at its end for a legend, as a share of the span."""
        room = max(room, 0.02) if self.slides else room
        end_s = self.end_s + room * (self.end_s - self.begin_s)
        if not self.slides:
            end_s = max(end_s, labelled_until(end_s, width))
        begin, end = (self.boundary(seconds=seconds) for seconds in (self.begin_s, end_s))
        return rrb.TimeAxis(view_range=rr.TimeRange(start=begin, end=end))

    @property
    def queried(self) -> rrb.VisibleTimeRange | None:
        """Which data is asked for at all; None: what the axis shows."""
        begin, end = (self.boundary(seconds=seconds) for seconds in (self.begin_s, self.end_s))
        return rrb.VisibleTimeRange(paths.TIMELINE, start=begin, end=end) if self.slides else None


EVERYTHING = Span(lambda seconds: rrb.TimeRangeBoundary.infinite())  # however long it has become


def sliding(window_s: float) -> Span:
    """The last `window_s` s."""
    return Span(rrb.TimeRangeBoundary.cursor_relative, -window_s, slides=True)


def whole(time_s: Array) -> Span:
    """A run from its first frame to its end, at least a second: the viewer does not bear an axis without length."""
    return Span(rrb.TimeRangeBoundary.absolute, 0.0, max(float(time_s[-1]), 1.0))


def plot(
    origin: str,
    name: str,
    span: Span,
    extent: Range | None = None,
    legend: bool = True,
    room: float = 0.0,
    height: float = LOW,
    width: float = WIDE,
) -> rrb.TimeSeriesView:
    """Curves over time; without an `extent` of their values the viewer chooses one.

    height, width  in points, of the axes in the smallest window
    """
    return rrb.TimeSeriesView(
        origin=origin,
        name=name,
        axis_x=span.axis(room, width),
        axis_y=rrb.ScalarAxis(range=labelled(extent, height), zoom_lock=False) if extent else None,
        plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.RightTop, visible=legend),
        time_ranges=span.queried,
    )


def below_legend(origin: str, name: str, span: Span, extent: Range, height: float = LOW) -> rrb.TimeSeriesView:
    """A plot whose curves keep below its legend."""
    return plot(origin, name, span, (extent[0], extent[0] + LEGEND_ROOM * (extent[1] - extent[0])), height=height)


def beside_legend(origin: str, name: str, span: Span, extent: Range, height: float = LOW) -> rrb.TimeSeriesView:
    """A plot whose curves end before its legend, whose names are as long as ever: a quarter of the time axis."""
    return plot(origin, name, span, extent, room=BESIDE_LEGEND, height=height)


def flat(origin: str, name: str, bounds: tuple[Range, Range], titlebar: bool = True) -> rrb.Spatial2DView:
    """A figure drawn by hand."""
    visible = rrb.VisualBounds2D(x_range=list(bounds[0]), y_range=list(bounds[1]))
    return rrb.Spatial2DView(
        origin=origin, name=name, titlebar=titlebar, visual_bounds=visible, background=list(paths.BACKGROUND)
    )


def key(origin: str, unit: str) -> rrb.Spatial2DView:
    """The colour bar of a map."""
    return flat(origin, f"[{unit}]", SQUEEZED)


def profile_view(root: str, rig: Rig, bounds: tuple[Range, Range]) -> rrb.Spatial2DView:
    """The temperatures along the screw."""
    return flat(f"{root}/{paths.PROFILE}", f"Temperature along the {body(rig)} [°C over mm]", bounds)


def screw_view(root: str, rig: Rig, growth: str, distance: float = 0.62) -> rrb.Spatial3DView:
    """The screw in space, seen from a `distance` in lengths of it; `growth` says how that is drawn."""
    lo, hi = rig.the_screw().from_mm, rig.the_screw().to_mm
    middle, length = (lo + hi) / 2, hi - lo
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


def state_view(root: str, span: Span, room: float = 0.0, without: Sequence[str] = ()) -> rrb.StateTimelineView:
    """What the machine does, whether to rely on the estimate, and which channels are broken, how and when; `without`
    lanes for which there is no room."""
    return _lanes(f"{root}/{paths.STATE}", "State", span, room, without)


def channel_states(root: str, span: Span) -> rrb.StateTimelineView:
    """What becomes of each channel that is not used all the time."""
    return _lanes(f"{root}/{paths.CHANNELS}", "Channels that are not used all the time", span, 0.0, ())


def _lanes(origin: str, name: str, span: Span, room: float, without: Sequence[str]) -> rrb.StateTimelineView:
    shown = ["$origin/**", *(f"- /{origin.partition('/')[0]}/{lane}" for lane in without)]
    return rrb.StateTimelineView(origin=origin, contents=shown, name=name, titlebar=False, time_view=span.axis(room))


def nis_view(
    root: str, span: Span, extent: Range | None = None, room: float = 0.3, width: float = WIDE
) -> rrb.TimeSeriesView:
    """Whether the innovations are as large as the filter expects."""
    name = "NIS over its channels, mean of 1 min [1]"
    return plot(f"{root}/{paths.NIS}", name, span, extent, room=room, width=width)


def residual_page(root: str, rig: Rig, span: Span) -> rrb.Container:
    """Where measurement and model part."""
    count = len(rig.thermometers)
    rows = f"mean of 1 min [K]; row = thermometer {ends(rig.thermometers)} from below; grey: left out or not read"
    maps = [
        rrb.Horizontal(
            plot(f"{root}/{at}", f"{title}, {rows}", span, (0.0, count + 1.0), legend=False),
            key(f"{root}/{bar}", "K"),
            column_shares=[9, 1],
        )
        for title, (at, bar) in zip(("Innovation", "Measured − open-loop"), paths.MAPS.items(), strict=True)
    ]
    name = "Sum of a minute's innovations over its sd [1]; within ±1.96 if white"
    white = plot(f"{root}/{paths.WHITENESS}", name, span, legend=False)
    lanes = rrb.Horizontal(state_view(root, span), channel_states(root, span))
    tests = rrb.Horizontal(white, nis_view(root, span))
    return rrb.Vertical(*maps, lanes, tests, row_shares=[3, 3, 3, 2.2], name="Residuals")


def channel_page(
    root: str,
    rig: Rig,
    span: Span,
    temperature_C: Range | None = None,
    innovation_K: Range | None = None,
    displacement_um: Range | None = None,
) -> rrb.Container:
    """What every channel reads, and beside it how far it is from what was expected."""
    apart = _channels(paths.INNOVATIONS, "Innovations of each tick,", root, rig, span, innovation_K, "K")
    pairs = zip(temperature_plots(root, rig, span, temperature_C), apart, strict=True)
    rows = rrb.Vertical(*(rrb.Horizontal(*pair) for pair in pairs))
    if rig.is_thermometer.all():
        return rrb.Horizontal(rows, name="Channels")
    at, words = f"{root}/{paths.DISPLACEMENT}", "Innovations [µm]"
    lengths = plot(at, words, span, displacement_um, room=0.6, height=550.0, width=300.0)
    return rrb.Horizontal(rows, lengths, column_shares=[3, 1], name="Channels")


def temperature_plots(root: str, rig: Rig, span: Span, temperature_C: Range | None = None) -> list[rrb.TimeSeriesView]:
    """What the thermometers read, in as few plots as leave every legend whole."""
    return _channels(paths.TEMPERATURES, "Thermometers", root, rig, span, temperature_C, "°C")


def _channels(
    what: str, words: str, root: str, rig: Rig, span: Span, extent: Range | None, unit: str
) -> list[rrb.TimeSeriesView]:
    groups = paths.thermometer_groups(rig, what)
    high = 550.0 / len(groups)
    named = {f"{root}/{at}": f"{words} {ends(rig.thermometers[columns])} [{unit}]" for at, columns in groups.items()}
    return [plot(at, name, span, extent, room=0.5, height=high, width=420.0) for at, name in named.items()]


def ends(names: Sequence[str]) -> str:
    """The first and the last of some names, or the only one."""
    return f"{names[0]} ... {names[-1]}" if len(names) > 1 else names[0]


def paged(count: int, most: int) -> list[range]:
    """Numbers 0 ... count - 1 in pages of so many."""
    return [range(first, min(first + most, count)) for first in range(0, count, most)]


def summary_view() -> rrb.TextDocumentView:
    """What the caller says of all runs."""
    return rrb.TextDocumentView(origin=paths.SUMMARY, name="Summary")


def by_run(names: Sequence[str], pages: Sequence[Sequence[rrb.Container]]) -> list[rrb.Container]:
    """The tabs of the only run, or a tab for each run with its own inside."""
    if len(pages) == 1:
        return list(pages[0])
    return [rrb.Tabs(*own, name=name) for name, own in zip(names, pages, strict=True)]


def tabbed(tabs: Sequence[rrb.Container]) -> rrb.Blueprint:
    """A layout of these tabs and nothing else."""
    return rrb.Blueprint(
        rrb.Tabs(*tabs, active_tab=0),
        rrb.TimePanel(state="collapsed", timeline=paths.TIMELINE, play_state="following"),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        auto_views=False,
        auto_layout=False,
    )
