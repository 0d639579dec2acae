"""Where the nut would have been, were the position another one."""

from typing import Any

import numpy as np

from estimator.cover import Cover
from estimator.record import Array
from estimator.rig import Rig


def moved(coverage: Array | Cover, rig: Rig, share: Any = 1.0, shift_mm: Any = 0.0) -> Array:
    """Coverage (ticks, cells) if every position p were share p + shift_mm: each cell looks where it would have been.

    Between cells by cubics whose slope has no jumps (Catmull-Rom); complex where share or shift is.
    """
    screw, nut, coverage = rig.the_screw(), rig.the_nut(), np.asarray(coverage)
    came_from = nut.centre_mm + (screw.x_mm - nut.direction * shift_mm - nut.centre_mm) / share
    place = (came_from - screw.x_mm[0]) / (screw.length * 1e3)
    place = np.where(
        (place.real >= 0) & (place.real <= screw.cells - 1), place, np.clip(place.real, 0, screw.cells - 1)
    )
    left = np.floor(place.real).astype(int)
    t = place - left
    weights = (t * (2 * t - t * t - 1), 2 + t * t * (3 * t - 5), t * (1 + 4 * t - 3 * t * t), t * t * (t - 1))
    cells = [np.clip(left + k - 1, 0, screw.cells - 1) for k in range(4)]
    told = sum(np.take(coverage, at, axis=1) * (w / 2) for at, w in zip(cells, weights, strict=True))
    total, now = coverage.sum(axis=1, keepdims=True), told.sum(axis=1, keepdims=True)
    return np.asarray(told * np.divide(total, now, out=np.ones_like(now), where=now.real > 0))
