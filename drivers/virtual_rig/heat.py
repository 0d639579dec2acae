"""The rig's heat: screw, nut, bearings and air put together and carried from tick to tick."""

from typing import NamedTuple

import numpy as np
from numba import njit

from drivers.virtual_rig import air, bearings, nut, screw
from drivers.virtual_rig.geometry import CHANNEL_MM, nut_centre_mm
from drivers.virtual_rig.heaters import Heaters
from drivers.virtual_rig.motion import TableMotion
from drivers.virtual_rig.planted import Strengths
from drivers.virtual_rig.weather import Weather

MOVING_STEPS = 20
RESTING_STEPS = 10
"""Steps of a 1 s tick: 50 ms while the nut moves, 100 ms while it stands."""


class Parts(NamedTuple):
    """The laws of everything that passes heat."""

    screw: screw.Screw
    nut: nut.Nut
    anchor: bearings.Bearing
    free: bearings.Bearing
    surface: air.Surface


class Temperatures(NamedTuple):
    """degC: both layers of the screw (CELLS,); bodies (4,): nut, anchor and free housing, and the grease's freshness"""

    bore: np.ndarray
    outer: np.ndarray
    bodies: np.ndarray


def parts(strength: Strengths, start_degc: float) -> Parts:
    """All laws at the strengths of their effects."""
    return Parts(
        screw.steel(strength["conduction"]),
        nut.nut(strength, start_degc),
        bearings.anchor_bearing(strength, start_degc),
        bearings.free_bearing(strength, start_degc),
        air.surface(strength),
    )


@njit(cache=True)
def advance(parts, now, omegas, centres, air_along, ambient, base, sources, dt):
    """Carry all temperatures over len(omegas) steps of dt; returns the mean torques of nut and bearings, N m: (2,)"""
    cover = np.zeros(now.outer.size)
    heat = np.zeros(now.outer.size)
    torque = np.zeros(2)
    bodies = now.bodies
    for k in range(omegas.size):
        omega = omegas[k]
        heat[:] = sources
        nut.lay(parts.nut, centres[k], cover)
        air.cool(parts.surface, omega, now.outer, cover, air_along, heat)
        bodies[0], drag = nut.rub(parts.nut, omega, now.outer, cover, heat, bodies[0], bodies[3], ambient, dt)
        bodies[1], anchor = bearings.turn(parts.anchor, omega, now.outer, heat, bodies[1], ambient, base, dt)
        bodies[2], free = bearings.turn(parts.free, omega, now.outer, heat, bodies[2], ambient, base, dt)
        bodies[3] = nut.settle(bodies[3], omega, dt)
        screw.spread(parts.screw, now.bore, now.outer, heat, dt)
        torque[0] += drag / omegas.size
        torque[1] += (anchor + free) / omegas.size
    return torque


class Rig:
    """The thermal rig at one instant; `tick` carries it over one second."""

    def __init__(self, strength: Strengths, weather: Weather, heaters: Heaters) -> None:
        self.weather = weather
        self.heaters = heaters
        self.parts = parts(strength, weather.start)
        layer = np.full(screw.CELLS, weather.start)
        self.now = Temperatures(layer.copy(), layer.copy(), np.array([*[weather.start] * 3, 1.0]))
        self.torque = np.zeros(2)

    def tick(self, t: float, motion: TableMotion) -> None:
        """From t to t + 1 s, with the table's motion at the middle of each step."""
        centres = nut.in_cells(nut_centre_mm(motion.position_mm))
        sources = self.heaters.always + self.heaters.driving * motion.moving.mean()
        unseen = self.weather.unseen(t)
        ambient, base = self.weather.ambient(t) + unseen, self.weather.base(t) + unseen
        air_along = self.weather.air_along(t)
        dt = 1.0 / motion.omega.size
        self.torque = advance(self.parts, self.now, motion.omega, centres, air_along, ambient, base, sources, dt)

    @property
    def mean(self) -> np.ndarray:
        """Mean of the layers at every cell, degC: (CELLS,)"""
        return screw.mean_temperature(self.now.bore, self.now.outer)

    @property
    def at_channels(self) -> np.ndarray:
        """Bore wall at the channels, degC: (15,)"""
        return np.interp(CHANNEL_MM, screw.CELL_MM, self.now.bore)

    @property
    def anchor_seat(self) -> float:
        """The screw under the anchor bearing, degC"""
        return float(self.parts.anchor.seat @ self.now.outer)

    @property
    def free_seat(self) -> float:
        """The screw under the free bearing, degC"""
        return float(self.parts.free.seat @ self.now.outer)


def step_middles(t: float, moving: bool) -> np.ndarray:
    """Middles of the steps of the tick from t to t + 1 s, s"""
    steps = MOVING_STEPS if moving else RESTING_STEPS
    return t + (np.arange(steps) + 0.5) / steps
