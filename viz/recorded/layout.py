"""Which view stands where in a saved file: tabs for the summary, for accuracy, and for what each run looked like."""

from collections.abc import Sequence

import rerun.blueprint as rrb

from viz.drawing import paths, profile, screw, views
from viz.drawing.scale import Range
from viz.recorded import accuracy, at_table, misfits, sure
from viz.recorded.run import JUDGED, ReviewedRun

MOST_LANES = 5  # that have room below the elongation; one looks for more by scrolling
LANE = 40.0  # points
HIGH, LESS_HIGH = 230.0, 110.0  # points, of the axes of elongation and of its error


def blueprint(runs: Sequence[ReviewedRun]) -> rrb.Blueprint:
    """The layout of a saved file."""
    judged = [run for run in runs if run.is_judged]
    common: list[rrb.Container] = [rrb.Horizontal(views.summary_view(), name="Summary")]
    common += [_accuracy(accuracy.figure_of(judged).bounds)] if judged else []
    own = views.by_run([run.name for run in runs], [pages_of(run) for run in runs])
    return views.tabbed([*own, *reversed(common)] if len(runs) == 1 else [*common, *own])


def pages_of(run: ReviewedRun) -> list[rrb.Container]:
    """The tabs of one run."""
    root, rig, span = paths.root(run.name), run.rig, views.whole(run.track.time_s)
    return [
        _overview(run),
        *([sure.page(root, run)] if sure.is_known(run) else []),
        *([at_table.page(root, run)] if at_table.is_known(run) else []),
        misfits.page(root, run),
        views.channel_page(root, rig, span, run.scale.temperature_C, run.scale.each_K, run.scale.each_um),
        rrb.Horizontal(views.events_view(root), name="Events"),
    ]


def _accuracy(bounds: tuple[Range, Range]) -> rrb.Container:
    titles = {name: f"Accuracy of the {name}: reference over estimate [µm]" for name in JUDGED}
    figures = [views.flat(f"{paths.ACCURACY}/{name}", title, bounds) for name, title in titles.items()]
    table = rrb.TextDocumentView(origin=f"{paths.ACCURACY}/{accuracy.BANDS}", name="Accuracy bands [µm]")
    return rrb.Horizontal(*figures, table, column_shares=[2, 2, 1.5], name="Accuracy")


def _overview(run: ReviewedRun) -> rrb.Container:
    scale, root, rig, span = run.scale, paths.root(run.name), run.rig, views.whole(run.track.time_s)
    words = rrb.TextDocumentView(origin=f"{root}/{paths.HEADLINE}", name="At a glance")
    name = "Elongation [µm]"
    curves = [views.beside_legend(f"{root}/{paths.ELONGATION}", name, span, scale.elongation_um, HIGH)]
    if scale.error_um:
        name = "Error: reference − estimate [µm]"
        curves.append(views.beside_legend(f"{root}/{paths.ERROR}", name, span, scale.error_um, LESS_HIGH))
    lanes = 25.0 + LANE * min(run.lanes, MOST_LANES)
    shown = [curves[0], views.state_view(root, span, views.BESIDE_LEGEND), *curves[1:]]
    right = rrb.Vertical(*shown, row_shares=[290.0, lanes, 175.0][: len(shown)])
    if rig.screw is None:
        return rrb.Horizontal(words, right, name="Overview")
    place = views.profile_view(root, rig, profile.axes_of(rig, scale).bounds)
    body = views.screw_view(root, rig, f"growth × {screw.exaggeration(rig, scale):g}", distance=0.36)
    return rrb.Horizontal(rrb.Vertical(place, words, body, row_shares=[5, 3.2, 2.4]), right, name="Overview")
