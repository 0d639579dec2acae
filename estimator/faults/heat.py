"""Slow departures of thermometers that may be heat which the model lacks, where a whole recording is at hand."""

from __future__ import annotations

import numpy as np

from estimator.record import Array
from estimator.rig import Rig

AS_FAR = 0.3  # of the other: as far as that


def may_be_heat(side: Array, rig: Rig) -> Array:
    """Which of the thermometers that drift may be right, (m,) bool; side (m,) how far, over time, 0: it does not.

    Heat moves the next thermometer too; beyond the last one there is none that could tell. Two that move as far as each
    other to opposite sides are swapped.
    """
    found = np.zeros(len(side), dtype=bool)
    places = [(rig.channels[name].at_mm, rig.index(name)) for name in rig.thermometers]
    order = np.array([i for at_mm, i in sorted((at, i) for at, i in places if at is not None)], dtype=int)
    if len(order) < 2:
        return found
    own = side[order]
    beside = np.array([np.append(0.0, own[:-1]), np.append(own[1:], 0.0)])
    sizes = np.abs([beside, np.broadcast_to(own, beside.shape)])
    swapped = ((beside * own < 0) & (sizes.min(axis=0) > AS_FAR * sizes.max(axis=0))).any(axis=0)
    is_last = np.isin(np.arange(len(own)), (0, len(own) - 1))
    found[order] = (own != 0) & ~swapped & ((beside != 0).any(axis=0) | is_last)
    return found
