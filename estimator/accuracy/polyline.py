"""The elongation without a model: the area under the polyline through the thermometers.

    X = rho * integral over the measured span of the polyline through the temperature rises

With a thermometer at both ends of the span this is the trapezoid sum over the spacings. Beyond the outermost
thermometer in use the rise is taken as constant.
"""

from collections.abc import Sequence

import numpy as np

from estimator.accuracy.displacement import jig_expansion
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig

FIRST_TICKS = 10


def weights(rig: Rig, names: Sequence[str]) -> Array:
    """um of elongation per K of each named thermometer's rise, (len(names),)."""
    screw = rig.the_screw()
    places = np.array([rig.channels[name].at_mm for name in names], dtype=float)
    lo, hi = screw.span_mm
    order = np.argsort(places)
    grid = np.unique(np.concatenate([[lo, hi], places[(places > lo) & (places < hi)]]))
    hats = np.array([np.interp(grid, places[order], row[order]) for row in np.eye(len(names))])
    return np.asarray(screw.expansion * 1e3 * np.trapezoid(hats, grid, axis=1))


def along_screw(rig: Rig, names: Sequence[str]) -> list[str]:
    """Those of the named channels that have a place on the screw."""
    return [name for name in names if rig.channels[name].at_mm is not None]


def elongation(recording: Recording, rig: Rig, names: Sequence[str] | None = None) -> Array:
    """Elongation since the first sample by the polyline through the named thermometers, (K,) um.

    A thermometer silent in a tick is left out of that tick's polyline, and one silent in the first ten ticks of all of
    them, since its rise is not known; NaN where fewer than two are left.
    """
    used = along_screw(rig, names or rig.thermometers)
    readings = recording.channels[:, [rig.index(name) for name in used]]
    rises = readings - np.array([_first(column[:FIRST_TICKS]) for column in readings.T])
    known = np.isfinite(rises)
    out = np.full(len(recording), np.nan)
    if len(used) < 2:
        return out
    for pattern in np.unique(known, axis=0):
        if pattern.sum() >= 2:
            ticks = (known == pattern).all(axis=1)
            out[ticks] = rises[np.ix_(ticks, pattern)] @ weights(
                rig, [n for n, k in zip(used, pattern, strict=True) if k]
            )
    return out


def _first(column: Array) -> float:
    """First known value of a column, NaN without one."""
    known = column[np.isfinite(column)]
    return float(known[0]) if len(known) else float("nan")


def joined_polyline(recording: Recording, rig: Rig, model: Model, polyline: Array) -> Array:
    """The last displacement reading plus the polyline's growth since then, (K,) um; the polyline before the first."""
    last, at = _last_reading(recording, rig, model, polyline)
    return np.where(at >= 0, last + polyline - polyline[np.maximum(at, 0)], polyline)


def last_reading(recording: Recording, rig: Rig, model: Model, polyline: Array) -> Array:
    """The last displacement reading held, (K,) um; 0 before the first."""
    last, at = _last_reading(recording, rig, model, polyline)
    return np.where(at >= 0, last, 0.0)


def _last_reading(recording: Recording, rig: Rig, model: Model, polyline: Array) -> tuple[Array, Array]:
    """Value (K,) um of the last reading so far and the tick it came in (-1: none yet).

    The reading's zero is that of the polyline at the first reading.
    """
    reading = recording.channels[:, rig.index("displacement")] - jig_expansion(recording, model)
    read = np.isfinite(reading) & np.isfinite(polyline)
    at = np.maximum.accumulate(np.where(read, np.arange(len(reading)), -1))
    if not read.any():
        return np.zeros(len(reading)), at
    first = int(np.argmax(read))
    return reading[np.maximum(at, first)] - reading[first] + polyline[first], at
