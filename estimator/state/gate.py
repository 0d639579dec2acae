"""The gate: which readings are fused, and why others are not. Reject the impossible, report the surprising."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from estimator.record import Array
from estimator.rig import Rig

Mute = Callable[[float], Array]  # by time, s: which channels are not to be fused, (m,) bool


@dataclass(frozen=True)
class Gate:
    """A reading beyond `sd` standard deviations is not fused; after `stubborn` such ticks in a row it is believed."""

    sd: float = 10.0
    stubborn: int = 5


@dataclass(frozen=True)
class Innovation:
    """Readings against predictions at one tick, each (m,).

    predicted, value, sd  the prediction; reading minus prediction; the sd that this should have, inf: no model
    fuse, why             whether the reading is used, and why not
    rejected              for how many ticks in a row the channel has been beyond the gate
    """

    predicted: Array
    value: Array
    sd: Array
    fuse: Array
    why: tuple[str, ...]
    rejected: Array


GATE = Gate(sd=10.0, stubborn=5)  # what stays beyond it, the model has to explain


def unmuted(rig: Rig) -> Mute:
    """Every channel may be fused at any time."""
    none = np.zeros(len(rig.names), dtype=bool)
    return lambda _: none


def innovation(reading: Array, predicted: Array, sd: Array, muted: Array, rejected: Array) -> Innovation:
    """Compare readings with predictions (m,); `rejected` (m,) as of the tick before. Muted ones are compared too."""
    value = reading - predicted
    wild = np.abs(value) > GATE.sd * sd
    rejected = np.where(wild, rejected + 1, 0)
    why = np.full(len(sd), "", dtype=object)
    why[wild & (rejected <= GATE.stubborn)] = "implausible jump"
    why[muted] = "muted"
    why[~np.isfinite(sd)] = "no model"
    why[~np.isfinite(reading)] = "not measured"
    return Innovation(predicted, value, sd, why == "", tuple(why), rejected)
