"""Runs into one .rrd file, layout included.

A file with several recordings would open with the first one only and no hint at the others, so all runs go into one
recording, each below its own name, side by side on a timeline that starts with each run's first frame.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import rerun as rr

from estimator.errors import InputError
from estimator.record import Array
from viz import accuracy, events, moment, paths, profile, residuals, screw, series
from viz.layout import blueprint
from viz.run import Indices, Run, first_stop_s
from viz.scale import Scale, minutes, scale_of

Named = TypeVar("Named", bound=Any)  # a dataclass with a name

PICTURE_S = 10.0  # profile and screw are kept every 10 s, curves at every tick


def save(path: Path, runs: Sequence[Run], summary: str, progress: Callable[[int], None] = lambda _: None) -> None:
    """Write all runs into `path` (.rrd) with `summary` (markdown); `progress` hears how many runs are done."""
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}")
    runs = distinct(runs)
    scales = [scale_of(run) for run in runs]
    layout = blueprint(runs, scales)
    rec = rr.RecordingStream(paths.APPLICATION, recording_id=uuid.uuid4())
    rec.set_log_time_enabled(False)
    rec.save(path, default_blueprint=layout)
    rec.send_blueprint(layout, make_active=True, make_default=True)
    rec.send_recording_name(", ".join(run.name for run in runs))
    rec.log(paths.SUMMARY, rr.TextDocument(summary, media_type=rr.MediaType.MARKDOWN), static=True)
    moment.send(rec, first_stop_s(runs[0]))
    accuracy.send(rec, runs)
    for done, (run, scale) in enumerate(zip(runs, scales, strict=True), start=1):
        send(rec, run, scale)
        progress(done)
    rec.disconnect()


def distinct(runs: Sequence[Named]) -> list[Named]:
    """The runs with names that lead to different paths: a name met before gets a number."""
    found: dict[str, Named] = {}
    for run in runs:
        name, number = run.name, 1
        while paths.root(name) in found:
            number += 1
            name = f"{run.name} ({number})"
        found[paths.root(name)] = replace(run, name=name)
    return list(found.values())


def send(rec: rr.RecordingStream, run: Run, scale: Scale) -> None:
    """Log one run: what it looks like, then all its rows."""
    root = paths.root(run.name)
    _curves(rec, root, run, scale)
    _residuals(rec, root, run, scale)
    shown = picture_ticks(run.track.time_s, run.track.profile_C)
    if run.rig.screw is not None and len(shown):
        _pictures(rec, root, run, scale, shown)
    events.send(rec, root, events.events_of(run))


def _curves(rec: rr.RecordingStream, root: str, run: Run, scale: Scale) -> None:
    track, at, heat = run.track, f"{root}/{paths.ELONGATION}", run.thermometers
    dense = bool(np.isfinite(run.reference_um).mean() > series.DENSE)
    series.style(rec, root, run.rig, run.reference_name, dense)
    series.send_band(rec, f"{at}/filter", track.time_s, track.elongation_um, track.sigma_um)
    series.send(rec, f"{at}/models", track.time_s, np.stack([run.polyline_um, track.open_loop_um], axis=-1))
    shown = series.spaced(track.time_s, run.readings_um, scale.time_s, scale.elongation_um)
    series.send_known(rec, f"{at}/readings", track.time_s[shown], run.readings_um[shown])
    if not np.array_equal(run.reference_um, run.readings_um, equal_nan=True):
        series.send_known(rec, f"{at}/reference", track.time_s, run.reference_um)
    series.send_band(rec, f"{root}/{paths.ERROR}/filter", track.time_s, run.errors_um["filter"], run.error_sd_um)
    series.send_known(rec, f"{root}/{paths.ERROR}/polyline", track.time_s, run.errors_um["polyline"])
    for plot, columns in paths.thermometer_groups(run.rig).items():
        series.send(rec, f"{root}/{plot}", track.time_s, track.measured[:, heat][:, columns])
    series.send(rec, f"{root}/{paths.INNOVATIONS}", track.time_s, track.innovation[:, heat])
    lengths = np.delete(track.innovation, heat, axis=1)
    read = np.flatnonzero(np.isfinite(lengths).any(axis=1))[1:]  # the first one sets the zero
    series.send(rec, f"{root}/{paths.DISPLACEMENT}", track.time_s[read], lengths[read])


def _residuals(rec: rr.RecordingStream, root: str, run: Run, scale: Scale) -> None:
    track, heat, names = run.track, run.thermometers, paths.channel_names(run.rig, "K")
    time_s, innovation, model_error = (
        track.time_s,
        track.innovation[:, heat],
        (track.measured - track.open_loop)[:, heat],
    )
    maps = (
        (paths.SURPRISE_MAP, paths.SURPRISE_BAR, innovation, scale.innovation_K),
        (paths.MODEL_MAP, paths.MODEL_BAR, model_error, scale.open_loop_K),
    )
    for at, bar, values, extent in maps:
        residuals.style_map(rec, f"{root}/{at}", f"{root}/{bar}", names, extent)
        begins, means = minutes(time_s, values)
        closed = np.append(begins, time_s[-1]), np.concatenate([means, means[-1:]])
        residuals.send_map(rec, f"{root}/{at}", *closed, extent)
    residuals.style_tests(rec, root, paths.channel_names(run.rig, "1"))
    middle, white = residuals.whiteness(time_s, innovation, track.innovation_sd[:, heat])
    series.send(rec, f"{root}/{paths.WHITENESS}/channels", middle, white)
    ends = time_s[[0, -1]]
    series.send(rec, f"{root}/{paths.WHITENESS}/bounds", ends, np.tile([1.96, -1.96], (2, 1)))
    middle, ratio, bounds = residuals.consistency(time_s, track.nis, track.nis_channels)
    series.send(rec, f"{root}/{paths.NIS}/window", middle, ratio)
    series.send(rec, f"{root}/{paths.NIS}/bounds", middle, bounds)


def _pictures(rec: rr.RecordingStream, root: str, run: Run, scale: Scale, shown: Indices) -> None:
    rig, track, axes = run.rig, run.track, profile.axes_of(run.rig, scale)
    time_s = track.time_s[shown]
    profile.style(rec, root, rig, scale, run.truth_C_rise is not None)
    profile.send(rec, root, axes, time_s, track.x_mm, track.profile_C[shown], track.profile_sd_K[shown])
    measured, fused = track.measured[shown][:, run.on_screw], track.fused[shown][:, run.on_screw]
    profile.send_measured(rec, root, axes, time_s, run.places_mm, measured, fused)
    if run.truth_C_rise is not None:
        start = np.interp(run.places_mm, track.x_mm, track.profile_C[shown[0]])
        profile.send_truth(rec, root, axes, time_s, run.places_mm, start + run.truth_C_rise[shown])
    screw.style(rec, root, rig, scale, track.x_mm)
    screw.send(rec, root, rig, scale, time_s, track.profile_C[shown], track.elongation_um[shown])
    position = run.recording.inputs.get("position")
    if rig.nut is not None and position is not None:
        known = shown[np.isfinite(position[shown])]
        if len(known):
            profile.send_nut(rec, root, axes, rig, track.time_s[known], position[known])
            screw.send_nut(rec, root, rig, track.time_s[known], position[known])


def picture_ticks(time_s: Array, profile_C: Array) -> Indices:
    """Indices of the first tick with a profile in each 10 s."""
    known = np.flatnonzero(np.isfinite(profile_C).all(axis=1) & (profile_C.shape[1] > 0))
    first = np.unique(np.floor(time_s[known] / PICTURE_S), return_index=True)[1]
    return known[first]
