"""Which view stands where in a saved file: tabs for the summary, for accuracy, and for what each run looked like."""

from __future__ import annotations

from collections.abc import Sequence

import rerun.blueprint as rrb

from estimator.rig import Rig
from viz.drawing import paths, profile, screw
from viz.drawing.scale import Range
from viz.drawing.views import (
    Whole,
    below_legend,
    channel_page,
    events_view,
    flat,
    profile_view,
    residual_page,
    screw_view,
    tabbed,
)
from viz.recorded import accuracy
from viz.recorded.run import JUDGED, Run, Scale


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


def pages_of(root: str, rig: Rig, scale: Scale) -> list[rrb.Container]:
    """The tabs of one run."""
    span = Whole(scale.time_s)
    return [
        _overview(root, rig, scale),
        residual_page(root, rig, span),
        channel_page(root, rig, span, scale.temperature_C),
    ]


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
    span = Whole(scale.time_s)
    curves = [below_legend(f"{root}/{paths.ELONGATION}", "Elongation [µm]", span, scale.elongation_um)]
    if scale.error_um:
        curves.append(below_legend(f"{root}/{paths.ERROR}", "Error: reference − estimate [µm]", span, scale.error_um))
    right = rrb.Vertical(*curves, events_view(root), row_shares=[*(4, 3)[: len(curves)], 2])
    if rig.screw is None:
        return rrb.Horizontal(right, name="Overview")
    place = profile_view(root, rig, profile.axes_of(rig, scale).bounds)
    body = screw_view(root, rig, f"growth × {screw.exaggeration(rig, scale):g}")
    return rrb.Horizontal(rrb.Vertical(place, body, row_shares=[5, 4]), right, name="Overview")
