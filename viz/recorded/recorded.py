"""Runs into one .rrd file, layout included."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import rerun as rr

from viz.drawing import columns, events, paths, profile, residuals, screw, series
from viz.drawing.columns import Indices
from viz.drawing.file import distinct, saved
from viz.drawing.profile import picture_ticks
from viz.drawing.scale import minutes
from viz.recorded import accuracy, happened
from viz.recorded.layout import blueprint
from viz.recorded.run import Run, Scale, first_stop_s, scale_of


def save(path: Path, runs: Sequence[Run], summary: str, progress: Callable[[int], None] = lambda _: None) -> None:
    """Write all runs into `path` (.rrd) with `summary` (markdown); `progress` hears how many runs are done."""
    runs = distinct(runs)
    scales = [scale_of(run) for run in runs]
    names = ", ".join(run.name for run in runs)
    with saved(path, blueprint(runs, scales), names, summary, first_stop_s(runs[0])) as rec:
        accuracy.send(rec, runs)
        for done, (run, scale) in enumerate(zip(runs, scales, strict=True), start=1):
            send(rec, run, scale)
            progress(done)


def send(rec: rr.RecordingStream, run: Run, scale: Scale) -> None:
    """Log one run: what it looks like, then all its rows."""
    root = paths.root(run.name)
    _curves(rec, root, run, scale)
    _residuals(rec, root, run, scale)
    shown = picture_ticks(run.track.time_s, run.track.profile_C)
    if run.rig.screw is not None and len(shown):
        _pictures(rec, root, run, scale, shown)
    events.send(rec, root, happened.events_of(run))


def _curves(rec: rr.RecordingStream, root: str, run: Run, scale: Scale) -> None:
    track, at = run.track, f"{root}/{paths.ELONGATION}"
    dense = bool(np.isfinite(run.reference_um).mean() > series.DENSE)
    series.style(rec, root, run.rig, {**series.POLYLINE, **series.OPEN_LOOP})
    series.style_reference(rec, root, run.reference_name, dense)
    series.send_track(rec, root, run.rig, track)
    series.band(rec, f"{at}/smoothed", "smoothed ±2 sd", paths.SMOOTHED, 1.5)
    series.send_band(rec, f"{at}/smoothed", track.time_s, run.smoothed_um, run.smoothed_sd_um)
    series.send(rec, f"{at}/models", track.time_s, np.stack([run.polyline_um, track.open_loop_um], axis=-1))
    shown = series.spaced(track.time_s, run.readings_um, scale.time_s, scale.elongation_um)
    series.send_known(rec, f"{at}/readings", track.time_s[shown], run.readings_um[shown])
    if not np.array_equal(run.reference_um, run.readings_um, equal_nan=True):
        series.send_known(rec, f"{at}/reference", track.time_s, run.reference_um)
    series.send_band(rec, f"{root}/{paths.ERROR}/filter", track.time_s, run.errors_um["filter"], run.error_sd_um)
    for name in ("smoothed", "polyline"):
        series.send_known(rec, f"{root}/{paths.ERROR}/{name}", track.time_s, run.errors_um[name])
    lengths = track.innovation[:, columns.lengths(run.rig)]
    read = np.flatnonzero(np.isfinite(lengths).any(axis=1))[1:]  # the first one sets the zero
    series.send(rec, f"{root}/{paths.DISPLACEMENT}", track.time_s[read], lengths[read])


def _residuals(rec: rr.RecordingStream, root: str, run: Run, scale: Scale) -> None:
    misfit = residuals.Misfit.of(run.track, run.thermometers)
    residuals.style(rec, root, run.rig)
    extents = dict(zip(residuals.MAPS, (scale.innovation_K, scale.open_loop_K), strict=True))
    for at, values in misfit.mapped().items():
        residuals.map_bar(rec, f"{root}/{residuals.MAPS[at]}", extents[at])
        begins, means = minutes(misfit.time_s, values)
        closed = np.append(begins, misfit.time_s[-1]), np.concatenate([means, means[-1:]])
        residuals.send_map(rec, f"{root}/{at}", *closed, extents[at])
    residuals.send_tests(rec, root, misfit)
    residuals.send_bounds(rec, root, misfit.time_s[[0, -1]])


def _pictures(rec: rr.RecordingStream, root: str, run: Run, scale: Scale, shown: Indices) -> None:
    rig, track, axes = run.rig, run.track, profile.axes_of(run.rig, scale)
    time_s = track.time_s[shown]
    profile.style(rec, root, rig, axes, run.truth_C_rise is not None)
    profile.frame(rec, root, rig, axes)
    profile.send(rec, root, axes, time_s, track.x_mm, track.profile_C[shown], track.profile_sd_K[shown])
    measured, fused = track.measured[shown][:, run.on_screw], track.fused[shown][:, run.on_screw]
    profile.send_measured(rec, root, axes, time_s, run.places_mm, measured, fused)
    if run.truth_C_rise is not None:
        start = np.interp(run.places_mm, track.x_mm, track.profile_C[shown[0]])
        profile.send_truth(rec, root, axes, time_s, run.places_mm, start + run.truth_C_rise[shown])
    screw.style(rec, root, rig, track.x_mm)
    screw.bar_labels(rec, root, rig, scale)
    screw.send(rec, root, rig, scale, time_s, track.profile_C[shown], track.elongation_um[shown])
    position = run.recording.inputs.get("position")
    if rig.nut is not None and position is not None:
        known = shown[np.isfinite(position[shown])]
        if len(known):
            profile.send_nut(rec, root, axes, rig, track.time_s[known], position[known])
            screw.send_nut(rec, root, rig, track.time_s[known], position[known])
