"""The estimate in the terms of a person."""

from __future__ import annotations

import numpy as np

from estimator.record import Array
from estimator.rig import Rig
from estimator.step import Mode


def modes(fused: Array, rig: Rig) -> Array:
    """What estimates rest on whose fused channels are (..., m): a Mode each."""
    thermometers = np.isin(rig.names, rig.thermometers)
    warm, other = fused[..., thermometers].any(axis=-1), fused[..., ~thermometers].any(axis=-1)
    return np.where(other, Mode.UPDATE, np.where(warm, Mode.PREDICT, Mode.COASTING))


def variances(rows: Array, P: Array) -> Array:
    """Diagonal of rows P rows', never below 0."""
    return np.maximum(((rows @ P) * rows).sum(axis=1), 0.0)
