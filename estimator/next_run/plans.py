"""Runs that could be made next: inside the strokes, speeds, levels and times that were seen so far."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from estimator.inputs.phase import speed_of, turns
from estimator.record import Array, Recording
from estimator.rig import Rig

PATTERNS = {"FS": (0.0, 1.0), "CS": (0.325, 0.6075), "ES": (0.505, 0.7875)}  # parts of the travel seen so far
STEP = "step"
DRIVES_S = (180.0, 420.0, 900.0, 1800.0, 3600.0)
STOP_S = 3600.0
ON = (1 / 8, 1 / 4, 1 / 2)  # of the longest recording, that an input is on; then off for the last of them
FEWEST = 3  # speeds
FULL = 99  # per cent of an input's readings are at most its highest level
MEASURED = ("position", "current", "displacement_direct")  # inputs that nobody sets by themselves


@dataclass(frozen=True)
class Plan:
    """A drive of the table, or inputs that are on for a time; then a rest with all of them off.

    pattern  FS, CS or ES of a table; "step" on a rig without one
    stroke_mm, speed_m_min  of the table, None for a step;  omega: rad/s, on the mean, the ends of its strokes included
    levels   of the inputs that are on, in the rig file's unit
    """

    pattern: str
    drive_s: float
    stop_s: float
    stroke_mm: tuple[float, float] | None = None
    speed_m_min: float | None = None
    omega: float = 0.0
    levels: Mapping[str, float] = field(default_factory=dict)


def plans(rig: Rig, recordings: Sequence[Recording]) -> list[Plan]:
    """All that are tried; none where nothing was ever driven or on."""
    travels = rig.nut is not None and rig.screw is not None and {"speed", "position"} <= set(rig.inputs)
    return list(_drives(rig, recordings) if travels else _steps(rig, recordings))


def _drives(rig: Rig, recordings: Sequence[Recording]) -> Iterator[Plan]:
    """Patterns, speeds and times of a table."""
    places = np.concatenate([r.inputs["position"][turns(r.omega)] for r in recordings])
    places = places[np.isfinite(places)]
    if not len(places):
        return
    lo, travel = float(places.min()), float(np.ptp(places))
    for pattern, (begin, end) in PATTERNS.items():
        stroke = (lo + begin * travel, lo + end * travel)
        for speed, omega in _speeds(rig, recordings).items():
            for drive_s in DRIVES_S:
                yield Plan(pattern, drive_s, STOP_S, stroke, speed, omega)


def _speeds(rig: Rig, recordings: Sequence[Recording]) -> dict[float, float]:
    """rad/s by m/min: the lowest, middle and highest speed that was seen; the half of the lowest if there are fewer."""
    driven = [turns(r.omega) for r in recordings]
    of_tick = np.concatenate([speed_of(r, rig)[on] for r, on in zip(recordings, driven, strict=True)])
    omega = np.concatenate([r.omega[on] for r, on in zip(recordings, driven, strict=True)])
    seen = {float(v): float(omega[of_tick == v].mean()) for v in np.unique(of_tick)}
    speeds = list(seen)
    chosen = {speed: seen[speed] for speed in (speeds[0], speeds[len(speeds) // 2], speeds[-1])}
    return chosen if len(chosen) == FEWEST else {speeds[0] / 2: seen[speeds[0]] / 2} | chosen


def _steps(rig: Rig, recordings: Sequence[Recording]) -> Iterator[Plan]:
    """Each input alone at two levels, and all together; temperatures are taken as they come."""
    seen = {name: _levels(recordings, name) for name, s in rig.inputs.items() if s.unit != "degC"}
    seen = {name: levels for name, levels in seen.items() if levels and name not in MEASURED}
    longest = max(float(np.ptp(r.time_s)) for r in recordings)
    chosen = [{name: level} for name, levels in seen.items() for level in levels]
    if len(seen) > 1:
        chosen.append({name: max(levels) for name, levels in seen.items()})
    for levels in chosen:
        for share in ON:
            yield Plan(STEP, round(share * longest, -1), round(ON[-1] * longest, -1), levels=levels)


def _levels(recordings: Sequence[Recording], name: str) -> list[float]:
    """The highest level of an input that was seen, and the middle one of those that are not zero, or its half."""
    values = np.concatenate([r.inputs[name] for r in recordings])
    on: Array = values[np.isfinite(values) & (values != 0.0)]
    if not len(on):
        return []
    levels = {float(f"{v:.3g}") for v in (np.median(on), np.percentile(on, FULL))}
    return sorted(levels if len(levels) > 1 else {*levels, max(levels) / 2})
