"""What the machine was doing at each tick: driving, just stopped, or at rest for long; and how fast it drives."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from estimator.record import Array, Recording
from estimator.rig import AT_REST, RAD_S, Rig

COOLDOWN_S = 3600.0

EARLY_S = 600.0
CRUISING = 90  # per cent of the readings of a drive's speed are at most what it keeps between its ends
PHASES = {  # when, for a person
    "drive": "while driving",
    "early_stop": "in the first ten minutes after a stop",
    "late_stop": "at rest",
}


def turns(omega: Any) -> Any:
    """Whether the screw turns at these speeds, rad/s; not where they are unknown."""
    return omega > AT_REST


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
    """Speed of the drive that each tick belongs to or follows, (K,) m/min to two digits; 0 before any drive.

    That between the ends of the strokes, where the speed is an input; else the mean, ends included.
    """
    found, last = np.zeros(len(recording)), 0.0
    lead_m = (rig.screw.lead_mm if rig.screw else 0.0) * 1e-3
    for driving, ticks in phases(recording):
        if driving:
            last = float(f"{_cruising(recording, rig, ticks) / (2 * np.pi) * 60 * lead_m:.2g}")
        found[ticks] = last
    return found


def _cruising(recording: Recording, rig: Rig, ticks: Array) -> float:
    """rad/s that a drive keeps between the ends of its strokes."""
    mean = float(np.nanmedian(recording.omega[ticks]))
    if "speed" not in rig.inputs:
        return mean
    unit = RAD_S.get(rig.inputs["speed"].unit, 1.0)
    seen = np.abs(recording.inputs["speed"][ticks]) * unit
    return max(mean, float(np.nanpercentile(seen, CRUISING))) if np.isfinite(seen).any() else mean


def phases(recording: Recording) -> Iterator[tuple[bool, Array]]:
    """Drives and rests in order, as (driving, indices of the ticks)."""
    driving = turns(recording.omega)
    borders = np.flatnonzero(np.diff(driving)) + 1
    for ticks in np.split(np.arange(len(recording)), borders):
        yield bool(driving[ticks[0]]), ticks


def cooling(recording: Recording) -> Array:
    """Ticks at rest within 60 min after a stop, (K,) bool."""
    mask = np.zeros(len(recording), dtype=bool)
    driven = False
    for driving, ticks in phases(recording):
        if driven and not driving:
            mask[ticks] = recording.time_s[ticks] <= recording.time_s[ticks[0] - 1] + COOLDOWN_S
        driven = driven or driving
    return mask


def stopped(seconds: float, elongation_um: float, sigma_um: float, alone_um: float) -> str:
    """A sentence on a drive that has stopped: how long it was, if known; where the screw grows, how far it has, and how
    far by the model alone."""
    after = f" after {seconds:.0f} s" if np.isfinite(seconds) else ""
    grown = (
        f" at an elongation of {elongation_um:.1f} ± {2 * sigma_um:.1f} µm (2 sd), {alone_um:.1f} by the model alone"
    )
    return f"drive stops{after}{grown if np.isfinite(elongation_um) else ''}"


def stops(recording: Recording) -> list[float]:
    """Times at which a drive ended, s."""
    found = list(phases(recording))
    return [float(recording.time_s[ticks[-1]]) for driving, ticks in found[:-1] if driving]
