"""Slow departures of thermometers that may be heat which the model lacks, where a whole recording is at hand."""

from __future__ import annotations

import numpy as np

from estimator.record import Array
from estimator.rig import Rig


def may_be_heat(side: Array, rig: Rig) -> Array:
    """Which of the thermometers that drift may be right, (m,) bool; side (m,): > 0 to the warm side, 0: it does not.

    Heat moves the next thermometer too, to the same side; beyond the last one there is none that could tell.
    """
    found = np.zeros(len(side), dtype=bool)
    places = [(rig.channels[name].at_mm, rig.index(name)) for name in rig.thermometers]
    order = np.array([i for at_mm, i in sorted((at, i) for at, i in places if at is not None)], dtype=int)
    if len(order) < 2:
        return found
    way = np.sign(side[order])
    beside = np.array([np.append(0, way[:-1]), np.append(way[1:], 0)])
    together, against = (beside == way).any(axis=0), (beside == -way).any(axis=0)
    is_last = np.isin(np.arange(len(way)), (0, len(way) - 1))
    found[order] = (way != 0) & (together | (is_last & ~against))
    return found
