"""What the machine was doing at each tick: driving, just stopped, or at rest for long; and how fast it drives."""

from __future__ import annotations

import numpy as np

from estimator.displacement import phases
from estimator.record import Array, Recording
from estimator.rig import Rig

EARLY_S = 600.0
PHASES = ("drive", "early_stop", "late_stop")


def phase_of(recording: Recording) -> Array:
    """Phase of each tick, (K,) of str: drive, the first ten minutes after a stop, later (and before any drive)."""
    found, driven = np.full(len(recording), "late_stop", dtype="<U10"), False
    for driving, ticks in phases(recording):
        if driving:
            found[ticks] = "drive"
        elif driven:
            stopped = recording.time_s[ticks[0] - 1]
            found[ticks[recording.time_s[ticks] - stopped <= EARLY_S]] = "early_stop"
        driven = driven or driving
    return found


def speed_of(recording: Recording, rig: Rig) -> Array:
    """Usual speed of the drive that each tick belongs to or follows, (K,) m/min to two digits; 0 before any drive."""
    found, last = np.zeros(len(recording)), 0.0
    lead_m = (rig.screw.lead_mm if rig.screw else 0.0) * 1e-3
    for driving, ticks in phases(recording):
        if driving:
            last = float(f"{np.nanmedian(recording.omega[ticks]) / (2 * np.pi) * 60 * lead_m:.2g}")
        found[ticks] = last
    return found
