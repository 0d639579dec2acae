"""Which view stands where in a saved file: tabs for the summary, for accuracy, and for what each run looked like."""

from __future__ import annotations

from collections.abc import Sequence

import rerun.blueprint as rrb

from viz.drawing import paths, profile, screw, views
from viz.drawing.scale import Range
from viz.recorded import accuracy, misfits, sure
from viz.recorded.run import JUDGED, ReviewedRun

MOST_LANES = 5  # that have room below the elongation; one looks for more by scrolling


def blueprint(runs: Sequence[ReviewedRun]) -> rrb.Blueprint:
    """The layout of a saved file."""
    judged = [run for run in runs if run.is_judged]
    common = [rrb.Horizontal(views.summary_view(), name="Summary")]
    common += [_accuracy(accuracy.figure_of(judged).bounds)] if judged else []
    own = views.by_run([run.name for run in runs], [pages_of(run) for run in runs])
    return views.tabbed([*own, *reversed(common)] if len(runs) == 1 else [*common, *own])


def pages_of(run: ReviewedRun) -> list[rrb.Container]:
    """The tabs of one run."""
    root, rig, span = paths.root(run.name), run.rig, views.whole(run.track.time_s)
    return [
        _overview(run),
        *([sure.page(root, run)] if sure.is_known(run) else []),
        misfits.page(root, run),
        views.channel_page(root, rig, span, run.scale.temperature_C),
    ]


def _accuracy(bounds: tuple[Range, Range]) -> rrb.Container:
    titles = {name: f"Accuracy of the {name}: reference over estimate [µm]" for name in JUDGED}
    figures = [views.flat(f"{paths.ACCURACY}/{name}", title, bounds) for name, title in titles.items()]
    table = rrb.TextDocumentView(origin=f"{paths.ACCURACY}/{accuracy.BANDS}", name="Accuracy bands [µm]")
    return rrb.Horizontal(*figures, table, column_shares=[2, 2, 1.5], name="Accuracy")


def _overview(run: ReviewedRun) -> rrb.Container:
    scale, root, rig, span = run.scale, paths.root(run.name), run.rig, views.whole(run.track.time_s)
    plots = {paths.ELONGATION: ("Elongation [µm]", scale.elongation_um)}
    if scale.error_um:
        plots[paths.ERROR] = "Error: reference − estimate [µm]", scale.error_um
    curves = [views.beside_legend(f"{root}/{at}", name, span, extent) for at, (name, extent) in plots.items()]
    others = [6, *[2.8] * len(curves[1:]), 2]
    lanes = sum(others) * (0.03 + 0.088 * min(run.lanes, MOST_LANES))  # a lane is as high whatever stands below it
    shown = [curves[0], views.state_view(root, span, views.BESIDE_LEGEND), *curves[1:], views.events_view(root)]
    right = rrb.Vertical(*shown, row_shares=[others[0], lanes, *others[1:]])
    if rig.screw is None:
        return rrb.Horizontal(right, name="Overview")
    place = views.profile_view(root, rig, profile.axes_of(rig, scale).bounds)
    body = views.screw_view(root, rig, f"growth × {screw.exaggeration(rig, scale):g}")
    return rrb.Horizontal(rrb.Vertical(place, body, row_shares=[5, 4]), right, name="Overview")
