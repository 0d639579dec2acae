"""The workshop around the rig: air and machine base drift slowly by a few tenths of a kelvin."""

import math
from dataclasses import dataclass

import numpy as np

from drivers.virtual_rig.dice import dice
from drivers.virtual_rig.machine.geometry import CHANNEL_MM
from drivers.virtual_rig.machine.planted import Strengths
from drivers.virtual_rig.machine.screw import CELL_MM

DRIFT_PER_HOUR = 1.0  # K/h of base_drift, which the thermometers of air and base do not see
GRADIENT = 1.5  # K at either end of the channels
ALONG = CELL_MM / (CHANNEL_MM[-1] / 2.0) - 1.0  # -1 at channel 1, +1 at channel 15: (CELLS,)


@dataclass(frozen=True)
class Swing:
    """sum over (a, P, phi) of a [sin(2 pi t / P + phi) - sin phi]   K; periods in s"""

    waves: tuple[tuple[float, float, float], ...]

    def at(self, t: float) -> float:
        """Distance from the start, K"""
        return sum(a * (math.sin(2.0 * math.pi * t / p + phase) - math.sin(phase)) for a, p, phase in self.waves)


@dataclass(frozen=True)
class Weather:
    """Temperatures around the rig; everything stands at `start` at the first sample."""

    start: float
    air: Swing
    ground: Swing
    drift: float
    gradient: float

    def ambient(self, t: float) -> float:
        """What the ambient thermometer stands in, degC"""
        return self.start + self.air.at(t)

    def base(self, t: float) -> float:
        """What the base's thermometer stands in, degC"""
        return self.start + self.ground.at(t)

    def unseen(self, t: float) -> float:
        """How far air and base at the screw have drifted from their thermometers, K"""
        return self.drift * t / 3600.0

    def air_along(self, t: float) -> np.ndarray:
        """Air at every cell, degC: (CELLS,)"""
        return self.ambient(t) + self.unseen(t) + self.gradient * ALONG


def weather(seed: int, run: str, strength: Strengths) -> Weather:
    """The weather of one run: the start between 20 and 24 degC, air within 0.3 K of it, base within 0.15 K."""
    draw = dice(seed, run, "weather")
    return Weather(
        start=float(draw.uniform(20.0, 24.0)),
        air=_swing(draw, np.array([0.10, 0.05]), np.array([3.5, 1.2])),
        ground=_swing(draw, np.array([0.05, 0.02]), np.array([6.0, 2.5])),
        drift=DRIFT_PER_HOUR * strength["base_drift"],
        gradient=GRADIENT * strength["ambient_gradient"],
    )


def _swing(draw: np.random.Generator, amplitude: np.ndarray, hours: np.ndarray) -> Swing:
    period = 3600.0 * hours * draw.uniform(0.8, 1.25, hours.size)
    phase = draw.uniform(0.0, 2.0 * np.pi, hours.size)
    return Swing(tuple(zip(amplitude.tolist(), period.tolist(), phase.tolist(), strict=True)))
