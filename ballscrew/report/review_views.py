"""What the views of reviews show: each recording with all that was estimated from it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ballscrew.report.review_report import markdown
from ballscrew.workspace import Loaded, Workspace
from estimator.accuracy.review import Review
from viz.recorded.recorded import save
from viz.recorded.run import ReviewedRun


def save_views(path: Path, work: Workspace, loaded: Sequence[Loaded], reviews: Sequence[Review], view: bool) -> None:
    """Write the views, and open them if asked, at the first stop."""
    runs = [_run(one, review, work) for one, review in zip(loaded, reviews, strict=True)]
    with work.terminal.progress(f"writing {path}", len(runs)) as update:
        save(path, runs, markdown(reviews, work.rig), update)
    work.terminal.show_views(path, view, runs[0].first_stop_s)


def _run(one: Loaded, r: Review, work: Workspace) -> ReviewedRun:
    return ReviewedRun(
        name=one.path.stem,
        rig=work.rig,
        recording=r.recording,
        track=r.track,
        smoothed_um=r.estimates["smoothed"],
        smoothed_sd_um=r.smoothed_sd,
        polyline_um=r.estimates["polyline"],
        readings_um=r.readings,
        reference_um=r.reference,
        reference_name=r.reference_name,
        errors_um=r.errors,
        error_sd_um=r.sigma["filter"],
        truth_C_rise=one.truth.rises(work.rig.thermometers, r.recording.time_s) if one.truth else None,
    )
