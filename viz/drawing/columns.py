"""Which columns of a rig's channels a view takes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimator.record import Array
from estimator.rig import Rig

Flags = NDArray[np.bool_]

Indices = NDArray[np.intp]


def thermometers(rig: Rig) -> Indices:
    """Columns of the thermometers among the channels, in order."""
    return np.array([rig.index(name) for name in rig.thermometers], dtype=np.intp)


def lengths(rig: Rig) -> Indices:
    """Columns of the others, in order."""
    return np.setdiff1d(np.arange(len(rig.names)), thermometers(rig))


def on_screw(rig: Rig) -> Indices:
    """Columns of the thermometers that have a place on the screw."""
    return np.array([i for i, channel in enumerate(rig.channels.values()) if channel.at_mm is not None], dtype=np.intp)


def places_mm(rig: Rig) -> Array:
    """Places of those thermometers, mm."""
    return np.array([c.at_mm for c in rig.channels.values() if c.at_mm is not None], dtype=float)
