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
    nis_view,
    plot,
    profile_view,
    residual_page,
    screw_view,
    state_view,
    tabbed,
    temperature_plots,
)

ROOM = 0.3  # of the span, for the legend of the elongation


def blueprint(root: str, rig: Rig, frame: Axes | None, span: Span) -> rrb.Blueprint:
    """The layout of a live stream; `frame` is the profile's, None without a screw."""
    return tabbed([_overview(root, rig, frame, span), residual_page(root, rig, span), channel_page(root, rig, span)])


def _overview(root: str, rig: Rig, frame: Axes | None, span: Span) -> rrb.Container:
    status = rrb.TextDocumentView(origin=f"{root}/{paths.STATUS}", name="Status")
    events, nis, state = events_view(root), nis_view(root, span), state_view(root, span, ROOM)
    if frame is None:
        plots, words = temperature_plots(root, rig, span), rrb.Horizontal(status, events)
        return rrb.Vertical(*plots, state, nis, words, row_shares=[*[3] * len(plots), 1.4, 3, 3], name="Overview")
    elongation = plot(f"{root}/{paths.ELONGATION}", "Elongation [µm]", span, room=ROOM)
    body = screw_view(root, rig, "growth exaggerated", distance=0.36)
    left = rrb.Vertical(profile_view(root, rig, frame.bounds), body, status, row_shares=[5, 2.6, 2.8])
    right = rrb.Vertical(elongation, state, nis, events, row_shares=[5, 1.4, 2.6, 2.8])
    return rrb.Horizontal(left, right, name="Overview")
