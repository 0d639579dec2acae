"""How the table moves in a tick, and what planted heat follows of that."""

import math
from typing import NamedTuple

import numpy as np

from drivers.virtual_rig.machine.geometry import OMEGA_20


class Pace(NamedTuple):
    """How the table moves in a tick.

    omega         speeds of its steps, rad/s;   share: of the steps in motion
    since_stop_s  since it last moved, negative: it never has;   since_start_s: since it set off, 0 at rest
    fading_s      of the air after a stop, the machine's
    """

    omega: np.ndarray
    share: float
    since_stop_s: float
    since_start_s: float
    fading_s: float

    @property
    def rested(self) -> float:
        """Share of the tick at rest after a motion."""
        return (1.0 - self.share) * (self.since_stop_s >= 0.0)

    def power(self, exponent: float) -> float:
        """Mean of (omega / omega at 20 m/min)^exponent."""
        return float(((self.omega / OMEGA_20) ** exponent).mean())

    def fading(self, seconds: float) -> float:
        """At rest, 1 just after the stop."""
        return self.rested * math.exp(-max(self.since_stop_s, 0.0) / seconds)
