"""Heat whose shape is drawn by the seed: a place, a length, a sign, and a law that no list of effects has."""

import math
from typing import NamedTuple

import numpy as np

from drivers.virtual_rig.dice import dice
from drivers.virtual_rig.machine.geometry import OMEGA_20
from drivers.virtual_rig.machine.motion import Pace

DRAWN = "drawn_heat"
PLACES_MM, WIDTHS_MM = (150.0, 780.0), (15.0, 150.0)
WATTS = {  # of each kind, in the range where it shows beside what sensors scatter
    "power": (3.0, 10.0),
    "gate": (3.0, 10.0),
    "surge": (10.0, 25.0),
    "blast": (5.0, 12.0),
    "soak": (2.0, 5.0),
    "two": (2.0, 5.0),
}


class Drawn(NamedTuple):
    """One shape.

    kind      "power": |omega|^exponent;   "gate": while faster than `share` of 20 m/min;   "surge": a power that fades
              from the start of a drive on;   "blast": fades after a stop;   "soak": comes after a stop;
              "two": 1 while driving and `share` at rest after that
    watts     at a factor of 1, less than 0 cools
    seconds   in which it fades or comes
    """

    kind: str
    watts: float
    place_mm: float
    width_mm: float
    exponent: float
    seconds: float
    share: float

    def factor(self, pace: Pace) -> float:
        """What the watts are multiplied by in a tick."""
        if self.kind == "power":
            return pace.power(self.exponent)
        if self.kind == "gate":
            return float((pace.omega > self.share * OMEGA_20).mean())
        if self.kind == "surge":
            return pace.power(self.exponent) * math.exp(-pace.since_start_s / self.seconds)
        if self.kind == "blast":
            return pace.fading(self.seconds)
        if self.kind == "soak":
            return pace.rested - pace.fading(self.seconds)
        return pace.share + self.share * pace.rested


def drawn(seed: int) -> Drawn:
    """The shape that a seed draws."""
    draw = dice(seed, DRAWN)
    kind = str(draw.choice(list(WATTS)))
    return Drawn(
        kind,
        watts=float(draw.uniform(*WATTS[kind]) * draw.choice([-1.0, 1.0])),
        place_mm=float(round(draw.uniform(*PLACES_MM))),
        width_mm=float(np.exp(draw.uniform(*np.log(WIDTHS_MM)))),
        exponent=float(draw.uniform(0.4, 2.6)),
        seconds=float(np.exp(draw.uniform(*np.log((80.0, 2000.0))))),
        share=float(draw.uniform(0.2, 0.6)),
    )
