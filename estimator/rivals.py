"""Simple estimates that need no model: what the filter has to beat on the same recording."""

from __future__ import annotations

import numpy as np

from estimator.displacement import jig_expansion
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig


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
