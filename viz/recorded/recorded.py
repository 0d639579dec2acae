"""Runs into one .rrd file, layout included."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from viz.drawing import body, paths, profile, screw, series
from viz.drawing.entity import Entity
from viz.drawing.file import distinct, saved
from viz.drawing.scale import Indices, extent_of
from viz.lanes.lanes import Lanes
from viz.lanes.states import States, telling
from viz.recorded import accuracy, at_table, happened, misfits, sure
from viz.recorded.layout import blueprint
from viz.recorded.run import READINGS, ReviewedRun


def save(
    path: Path, runs: Sequence[ReviewedRun], summary: str, progress: Callable[[int], None] = lambda _: None
) -> None:
    """Write all runs into `path` (.rrd) with `summary` (markdown); `progress` hears how many runs are done."""
    runs = distinct(runs)
    names = ", ".join(run.name for run in runs)
    with saved(path, blueprint(runs), names, summary, runs[0].first_stop_s) as file:
        accuracy.send(file / paths.ACCURACY, runs)
        for done, run in enumerate(runs, start=1):
            send(file / paths.root(run.name), run)
            progress(done)


def send(at: Entity, run: ReviewedRun) -> None:
    """Log one run: what it looks like, then all its rows."""
    (at / paths.HEADLINE).text(run.headline)
    _curves(at, run)
    misfits.send(at, run)
    if at_table.is_known(run):
        at_table.send(at, run)
    shown = profile.picture_ticks(run.track.time_s, run.track.profile_C)
    if run.rig.screw is not None and len(shown):
        _pictures(at, run, shown)
    _lanes(at, run)
    series.send_events(at, happened.events_of(run))


def _curves(at: Entity, run: ReviewedRun) -> None:
    track, length, error = run.track, at / paths.ELONGATION, at / paths.ERROR
    series.style(at, run.rig, {**series.POLYLINE, **series.OPEN_LOOP})
    series.style_reference(at, run.reference_name, bool(np.isfinite(run.reference_um).mean() > series.DENSE))
    series.send_track(at, run.rig, track)
    (length / "smoothed").band("smoothed ±2 sd", paths.SMOOTHED, 1.5)
    (length / "smoothed").banded(track.time_s, run.smoothed_um, run.smoothed_sd_um)
    (length / "models").curves(track.time_s, np.stack([run.polyline_um, track.open_loop_um], axis=-1))
    _readings(at, run)
    if run.reference_name != READINGS:
        (length / "reference").known(track.time_s, run.reference_um)
    (error / "filter").banded(track.time_s, run.errors_um["filter"], run.error_sd_um)
    for name in ("smoothed", "polyline"):
        (error / name).known(track.time_s, run.errors_um[name])
    lengths = track.innovation[:, ~run.rig.is_thermometer]
    read = np.flatnonzero(np.isfinite(lengths).any(axis=1))[1:]  # the first one sets the zero
    (at / paths.DISPLACEMENT).curves(track.time_s[read], lengths[read])
    sure.send(at, run)


def _readings(at: Entity, run: ReviewedRun) -> None:
    """Readings that the filter used, those that it did not, and the dial at rest, joined to the drives around it."""
    time_s, length, dial = run.track.time_s, at / paths.ELONGATION, ~run.turning & ~run.read
    for single in (run.read, run.turning & ~run.read):
        um = np.where(single, run.readings_um, np.nan)
        shown = series.spaced(time_s, um, extent_of(time_s), run.scale.elongation_um)
        series.send_readings(at, time_s[shown], um[shown], single[shown] & run.read[shown])
    if np.isfinite(run.level_um[dial]).any():
        (length / "dial").band(series.DIAL, paths.DIAL, 1.0)
        (length / "dial").spans(time_s, np.where(dial, run.level_um, np.nan), run.level_sd_um)


def _lanes(at: Entity, run: ReviewedRun) -> None:
    lanes, states = Lanes(at), States(run.rig)
    for judged in run.judged:
        lanes.send(judged)
    for k in telling(run.track, run.recording.omega).tolist():
        lanes.follow(states.tick(run.recording.sample(k), run.track.step(k, ())))
    lanes.follow(states.end())


def _pictures(at: Entity, run: ReviewedRun, shown: Indices) -> None:
    rig, track, scale = run.rig, run.track, run.scale
    axes = profile.axes_of(rig, scale)
    profile.style(at, rig, axes, run.truth_C_rise is not None)
    profile.frame(at, rig, axes)
    screw.style(at, rig, track.profile_C.shape[1])
    screw.bar_labels(at, rig, scale)
    for some in profile.pieces(shown):
        body.send(at, rig, axes, scale, track, some)
    if run.truth_C_rise is not None:
        at_mm = profile.places_mm(rig)[rig.is_thermometer]
        start = np.interp(at_mm, track.x_mm, track.profile_C[shown[0]])
        profile.send_truth(at, axes, track.time_s[shown], at_mm, start + run.truth_C_rise[shown])
    if "position" in run.recording.inputs:
        body.send_nut(at, rig, axes, track.time_s[shown], run.recording.inputs["position"][shown])
