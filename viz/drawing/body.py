"""Profile and screw together: pictures of some ticks of a run."""

import numpy as np

from estimator.faults.fault import MAY_DRIFT, Fault
from estimator.record import Array
from estimator.rig import Rig
from estimator.step import Track
from viz.drawing import profile, screw
from viz.drawing.entity import Entity
from viz.drawing.frames import Axes
from viz.drawing.scale import BodyScale, Indices, clock


def send(at: Entity, rig: Rig, axes: Axes, scale: BodyScale, track: Track, shown: Indices) -> None:
    """Log the ticks `shown` of a track. A broken thermometer stands at the frame's edge."""
    time_s, mean = track.time_s[shown], track.profile_C[shown]
    profile.send(at, axes, time_s, mean, track.profile_sd_K[shown])
    inside = np.clip(track.measured[shown], *scale.temperature_C)
    profile.send_measured(at, axes, time_s, profile.places_mm(rig), inside, track.fused[shown])
    profile.send_faults(at, axes, time_s, profile.places_mm(rig), inside, _said(track, shown))
    screw.send(at, rig, scale, time_s, mean, track.elongation_um[shown])


def _said(track: Track, shown: Indices) -> Array:
    """What is wrong with each channel, or may be, (n, m) str, "" where nothing is."""
    said = np.full((len(shown), len(track.names)), "", dtype=object)
    for row, i in np.argwhere(track.fault[shown] > Fault.JUDGED):
        k = shown[row]
        said[row, i] = f"{track.names[i]} {Fault(track.fault[k, i]).word} since {clock(track.since_s[k, i])}"
    for row, i in np.argwhere((track.may_drift_K[shown] != 0) & (track.fault[shown] == Fault.NONE)):
        k = shown[row]
        by = f"{track.may_drift_K[k, i]:+.2f} K"
        said[row, i] = f"{track.names[i]} {MAY_DRIFT}, {by} since {clock(track.since_s[k, i])}"
    return said


def send_nut(at: Entity, rig: Rig, axes: Axes, time_s: Array, position_mm: Array) -> None:
    """Log where the nut is, (n,), where that is known."""
    known = np.isfinite(position_mm)
    if rig.nut is not None and known.any():
        profile.send_nut(at, axes, rig, time_s[known], position_mm[known])
        screw.send_nut(at, rig, time_s[known], position_mm[known])
