"""Which view stands where while a run goes on: the window slides along, the cursor follows.

What is to be read at a glance stands above all pages of a stream that is served; in a file, where one looks back, it
would be of another moment. The first page holds without scrolling in a window of 1366 x 768.
"""

from collections.abc import Sequence

import rerun.blueprint as rrb

from estimator.rig import Rig
from viz.drawing import paths
from viz.drawing.frames import Axes
from viz.drawing.scale import Range
from viz.drawing.views import (
    Span,
    channel_page,
    ends,
    events_view,
    flat,
    key,
    nis_view,
    plot,
    profile_view,
    residual_page,
    screw_view,
    state_view,
    tabbed,
    temperature_plots,
)
from viz.lanes.banner import HEIGHT, WIDTH
from viz.live.readings import READING
from viz.live.table import axes_of
from viz.recorded.sure import PARTS, TITLE, share_bars

ROOM = 0.3  # of the span, for the legend of the elongation
EVERY_FAULT = f"{paths.STATE}/{paths.FAULTS}/**"
LABELLED = 10.5  # an axis from 0 on that ends here has two labels
BANNER_SHARE = 0.14  # of a page's height


def blueprint(root: str, rig: Rig, frame: Axes | None, span: Span, now: bool) -> rrb.Blueprint:
    """The layout of a live stream; `frame` is the profile's, None without a screw; `now`: whether one looks on."""
    said = [paths.MODE, paths.THERMOMETERS] if now else []  # by the banner
    pages = [
        _overview(root, rig, frame, span, said),
        *([_body(root, rig, rig.stroke_mm, span)] if rig.screw else []),
        *([_sure(root, span)] if READING in rig.channels else []),
        residual_page(root, rig, span),
        channel_page(root, rig, span),
        _words(root),
    ]
    return tabbed([_below_banner(root, page) for page in pages] if now else pages)


def _below_banner(root: str, page: rrb.Container) -> rrb.Container:
    bounds = (0.0, float(WIDTH)), (0.0, float(HEIGHT))
    banner = flat(f"{root}/{paths.BANNER}", "Now", bounds, titlebar=False)
    return rrb.Vertical(banner, page, row_shares=[BANNER_SHARE, 1 - BANNER_SHARE], name=page.name)


def _overview(root: str, rig: Rig, frame: Axes | None, span: Span, said: Sequence[str]) -> rrb.Container:
    events, nis = events_view(root), nis_view(root, span)
    state, missed = state_view(root, span, ROOM, said), _missed(root, rig, span)
    if frame is None:
        plots = temperature_plots(root, rig, span)
        left = rrb.Vertical(*plots, missed, row_shares=[*[5 / len(plots)] * len(plots), 3])
        return rrb.Horizontal(left, rrb.Vertical(state, nis, events, row_shares=[4, 3, 2.6]), name="Overview")
    elongation = plot(f"{root}/{paths.ELONGATION}", "Elongation [µm]", span, room=ROOM)
    left = rrb.Vertical(profile_view(root, rig, frame.bounds), missed, nis, row_shares=[5, 2.6, 2])
    right = rrb.Vertical(elongation, state, events, row_shares=[3.9, 4.2, 1.95])
    return rrb.Horizontal(left, right, name="Overview")


def _missed(root: str, rig: Rig, span: Span) -> rrb.Container:
    """Where and when the model alone fails, in half the width of a page."""
    (_, (at, bar)), rows = paths.MAPS.items(), max(len(rig.thermometers) + 1.0, LABELLED)
    name = f"Measured − open-loop [K], 1 min; {ends(rig.thermometers)} from below; grey: left out or not read"
    stripes = plot(f"{root}/{at}", name, span, (0.0, rows), legend=False)
    return rrb.Horizontal(stripes, key(f"{root}/{bar}", "K"), column_shares=[5, 1])


def _body(root: str, rig: Rig, stroke_mm: Range | None, span: Span) -> rrb.Container:
    """The body in colour; and what a control compensates, where there is a table."""
    how = "growth exaggerated"
    if stroke_mm is None:
        return rrb.Horizontal(screw_view(root, rig, how), name="In colour")
    error = plot(f"{root}/{paths.TABLE}", "Error at the table [µm]", span, room=ROOM)
    title = "Error at the table over its stroke [µm over mm]"
    stroke = flat(f"{root}/{paths.STROKE}", title, axes_of(stroke_mm).bounds)
    state = state_view(root, span, ROOM, [paths.MODE, paths.THERMOMETERS, EVERY_FAULT])
    left, right = (
        rrb.Vertical(stroke, screw_view(root, rig, how, 0.36), row_shares=[5, 2.6]),
        rrb.Vertical(error, state, row_shares=[5, 3]),
    )
    return rrb.Horizontal(left, right, name="At the table")


def _sure(root: str, span: Span) -> rrb.Container:
    """How sure the filter is."""
    title = "Displacement, used readings − prediction before, within ±2 sd [µm]"
    error = plot(f"{root}/{paths.SURE}", title, span, room=0.2)
    sd = plot(f"{root}/{paths.SURE_SD}", "Standard deviation of the estimate [µm]", span, room=0.2)
    share = flat(
        f"{root}/{paths.SURE_BARS}", TITLE, share_bars(dict.fromkeys(("all", *PARTS.values()), 1.0)).frame.bounds
    )
    others = [EVERY_FAULT, paths.THERMOMETERS, *(f"{paths.STATE}/{lane}" for lane in (paths.ALARMS, paths.PUBLISHED))]
    state, below = state_view(root, span, 0.2, others), rrb.Horizontal(sd, share, column_shares=[3, 2])
    return rrb.Vertical(error, state, below, row_shares=[4, 3.2, 4.8], name="How sure")


def _words(root: str) -> rrb.Container:
    """What happened, and how the monitor itself is."""
    status = rrb.TextDocumentView(origin=f"{root}/{paths.STATUS}", name="Status")
    return rrb.Horizontal(events_view(root), status, column_shares=[3, 2], name="Events")
