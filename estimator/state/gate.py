"""The gate: reject the impossible, report the surprising."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from estimator.record import Array

FIRST_SD_K = 0.3  # the first reading may be a spike too, and has nothing to be checked against
Mute = Callable[[float], Array]


@dataclass(frozen=True)
class Gate:
    """A reading beyond `sd` standard deviations is not fused; after `stubborn` such ticks in a row it is believed."""

    sd: float = 10.0
    stubborn: int = 5


GATE = Gate(sd=10.0, stubborn=5)  # reject the impossible, report the surprising; what stays, the model has to explain
