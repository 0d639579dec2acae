"""What the views of reviews show: each recording with all that was estimated from it."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ballscrew.at_a_glance import glance
from ballscrew.report.review_report import TITLES, error_rows
from ballscrew.report.sections import table
from ballscrew.report.use_report import left_out
from ballscrew.terminal import duration
from ballscrew.workspace import Loaded, Workspace
from estimator.accuracy.accuracy import least_squares_line
from estimator.accuracy.doubts import doubts
from estimator.accuracy.review import Review
from estimator.alarms.alarms import Alarms
from estimator.alarms.trust import Watch
from estimator.faults.fault import Fault
from estimator.faults.sentences import sentences
from estimator.faults.use import MUTED
from estimator.record import Recording
from estimator.rig import Rig
from estimator.step import Track
from viz.lanes.standing import Judged
from viz.recorded.recorded import save
from viz.recorded.run import ReviewedRun, first_stop_s

HEARD = 0.1  # of a tick before its close, the last frame of the drive in it


def save_views(
    path: Path, work: Workspace, loaded: Sequence[Loaded], reviews: Sequence[Review], said: str, view: bool
) -> None:
    """Write the views, with what is said of the model, and open them if asked, at the first stop."""
    runs = [_run(one, review, work) for one, review in zip(loaded, reviews, strict=True)]
    with work.terminal.progress(f"writing {path}", len(runs)) as update:
        save(path, runs, markdown(reviews, work.rig, said), update)
    work.terminal.show_views(path, view, runs[0].first_stop_s)


def markdown(reviews: Sequence[Review], rig: Rig, said: str = "") -> str:
    """The summary page of the views: what is said of the model, the overall table, the least-squares lines, and what
    was not used."""
    lines = ["# Elongation: reference minus estimate", "", *([said, ""] if said else []), *table(error_rows(reviews))]
    lines += ["", "The least-squares line Y = aX + b of reference Y against estimate X, and the band around it:", ""]
    for name in ("filter", "polyline"):
        found = [r for r in reviews if name in r.errors]
        reference = np.concatenate([r.reference for r in found])
        estimate = reference - np.concatenate([r.errors[name] for r in found])
        a, b, band = least_squares_line(estimate, reference)
        if np.isfinite(a):
            lines.append(f"- {TITLES[name]}: Y = {a:.4f} X {b:+.2f} um, {band[0]:+.2f} .. {band[1]:+.2f} um")
    if rows := left_out([r.use for r in reviews], rig):
        lines += ["", "Sensors that failed:", "", *table(rows)]
    for r in reviews:
        used = f"{r.recording.frames} frames, reference: {r.reference_name}, NIS {r.nis_mean:.2f}"
        lines += ["", f"**{r.recording.name}**: {duration(r.recording.time_s[-1])}, {used}"]
        lines += [f"- {sentence}" for sentence in (*sentences([r.use], rig), *doubts([r], rig))]
        lines += [f"- not used: {count} x {reason}" for reason, count in r.recording.skipped.items()]
        lines += [f"- {note}" for note in r.recording.notes]
    return "\n".join(lines)


def _run(one: Loaded, r: Review, work: Workspace) -> ReviewedRun:
    at_table = one.truth.at_table(r.table.at_mm, r.recording.time_s) if one.truth else np.empty(0)
    return ReviewedRun(
        name=one.path.stem,
        rig=work.rig,
        recording=r.recording,
        track=r.track,
        smoothed_um=r.estimates["smoothed"],
        smoothed_sd_um=r.smoothed_sd,
        polyline_um=r.estimates["polyline"],
        readings_um=r.readings.um,
        level_um=r.readings.level,
        level_sd_um=r.readings.sd,
        reference_um=r.reference,
        reference_name=r.reference_name,
        errors_um=r.errors,
        error_sd_um=r.sigma["filter"],
        nis_of=r.nis_of,
        table=r.table,
        headline=glance(r, work.rig, work.model, first_stop_s(r.recording)),
        judged=list(judged(r.recording, r.track, work.rig)),
        truth_C_rise=one.truth.rises(work.rig.thermometers, r.recording.time_s) if one.truth else None,
        table_truth_um=at_table if np.isfinite(at_table).any() else None,
    )


def judged(recording: Recording, track: Track, rig: Rig) -> Iterator[Judged]:
    """What the monitor would have said of the estimate and the channels, wherever that changes."""
    muted = np.isfinite(track.measured) & ~track.fused & (track.fault == Fault.NONE)
    begun = muted[np.flatnonzero(track.begins)[-1]]
    tests, watch = Alarms(rig), Watch(rig, int((rig.is_thermometer & ~begun).sum()))
    before, none = None, ("",) * len(rig.names)
    for k, sample in enumerate(recording):
        step = track.step(k, tuple(np.where(muted[k], MUTED, "")) if muted[k].any() else none)
        tests.step(step)
        if np.isfinite(sample.inputs.get("speed", np.nan)):
            watch.drive(step.time_s - HEARD * rig.tick_s)
        watch.tick(sample, step, tests.diverged)
        said = watch.trust(step.time_s).why, tuple(tests.active.values())
        if said != before:
            yield Judged(step.time_s, *said)
        before = said
