"""Readings against their predictions, and why some are not fused."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from estimator.faults.fault import Fault
from estimator.record import Array
from estimator.rig import Rig

Mute = Callable[[float], Array]  # by time, s: which channels are not to be fused, (m,) bool

FIRST_SD = 10.0  # the gate of the first readings, which nothing else can be told of


@dataclass(frozen=True)
class Innovation:
    """Readings against predictions at one tick, each (m,).

    predicted, value, sd  the prediction; reading minus prediction; the sd that this should have, inf: no model
    """

    predicted: Array
    value: Array
    sd: Array

    @property
    def usable(self) -> Array:
        """Which channels were read and have a model."""
        return np.isfinite(self.value) & np.isfinite(self.sd)

    def why(self, fault: Array, muted: Array) -> tuple[str, ...]:
        """Why channels are not fused, by their faults and those that are muted; empty where they are."""
        why = np.array([Fault(code).why for code in fault], dtype=object)
        why[muted] = "muted"
        why[~np.isfinite(self.sd)] = "no model"
        why[~np.isfinite(self.value)] = "not measured"
        return tuple(why)


def unmuted(rig: Rig) -> Mute:
    """Every channel may be fused at any time."""
    none = np.zeros(len(rig.names), dtype=bool)
    return lambda _: none


def first_faults(first: Innovation) -> Array:
    """Of the first readings, which are too far off to begin with: a Fault each, (m,)."""
    return np.where(np.abs(first.value) > FIRST_SD * first.sd, Fault.JUDGED, Fault.NONE).astype(np.int8)
