"""Which view stands where while a run goes on: the window slides along, the cursor follows."""

from __future__ import annotations

import rerun.blueprint as rrb

from estimator.rig import Rig
from viz.drawing import paths
from viz.drawing.frames import Axes
from viz.drawing.views import (
    Span,
    channel_page,
    events_view,
    flat,
    nis_view,
    plot,
    profile_view,
    residual_page,
    screw_view,
    state_view,
    tabbed,
    temperature_plots,
)
from viz.recorded.sure import PARTS, TITLE, share_bars

ROOM = 0.3  # of the span, for the legend of the elongation


def blueprint(root: str, rig: Rig, frame: Axes | None, span: Span) -> rrb.Blueprint:
    """The layout of a live stream; `frame` is the profile's, None without a screw."""
    return tabbed(
        [
            _overview(root, rig, frame, span),
            *_sure(root, rig, span),
            residual_page(root, rig, span),
            channel_page(root, rig, span),
        ]
    )


def _sure(root: str, rig: Rig, span: Span) -> list[rrb.Container]:
    """How sure the filter is, where it reads a length."""
    if rig.is_thermometer.all():
        return []
    title = "Displacement, used readings − prediction before, within ±2 sd [µm]"
    error = plot(f"{root}/{paths.SURE}", title, span, room=0.2)
    sd = plot(f"{root}/{paths.SURE_SD}", "Standard deviation of the estimate [µm]", span, room=0.2)
    share = flat(
        f"{root}/{paths.SURE_BARS}", TITLE, share_bars(dict.fromkeys(("all", *PARTS.values()), 1.0)).frame.bounds
    )
    below = rrb.Horizontal(sd, share, column_shares=[3, 2])
    return [rrb.Vertical(error, state_view(root, span, 0.2), below, row_shares=[5, 3.4, 4], name="How sure")]


def _overview(root: str, rig: Rig, frame: Axes | None, span: Span) -> rrb.Container:
    status = rrb.TextDocumentView(origin=f"{root}/{paths.STATUS}", name="Status")
    events, nis, state = events_view(root), nis_view(root, span), state_view(root, span, ROOM)
    if frame is None:
        plots, words = temperature_plots(root, rig, span), rrb.Horizontal(status, events)
        return rrb.Vertical(*plots, state, nis, words, row_shares=[*[3] * len(plots), 3, 3, 3], name="Overview")
    elongation = plot(f"{root}/{paths.ELONGATION}", "Elongation [µm]", span, room=ROOM)
    body = screw_view(root, rig, "growth exaggerated", distance=0.36)
    left = rrb.Vertical(profile_view(root, rig, frame.bounds), body, status, row_shares=[5, 2.6, 2.8])
    right = rrb.Vertical(elongation, state, nis, events, row_shares=[4.4, 3.4, 2.2, 2])
    return rrb.Horizontal(left, right, name="Overview")
