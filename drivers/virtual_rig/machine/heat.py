"""The rig's heat: screw, nut, bearings and air put together and carried from tick to tick."""

import numpy as np

from drivers.virtual_rig.machine import air, bearings, nut, screw
from drivers.virtual_rig.machine.flows import Around, Parts, Temperatures, advance
from drivers.virtual_rig.machine.geometry import CHANNEL_MM, OMEGA_20, nut_centre_mm
from drivers.virtual_rig.machine.heaters import Heaters
from drivers.virtual_rig.machine.motion import TableMotion
from drivers.virtual_rig.machine.planted import Strengths
from drivers.virtual_rig.machine.weather import Weather
from drivers.virtual_rig.population.constants import Machine

MOVING_STEPS, RESTING_STEPS = 20, 10  # of a 1 s tick: 50 ms while the nut moves, 100 ms while it stands


def parts(machine: Machine, strength: Strengths) -> Parts:
    """All laws of a machine at the strengths of their effects."""
    return Parts(
        screw.steel(machine.screw, strength["conduction"]),
        nut.nut(machine.nut, strength),
        bearings.bearing(machine.anchor, "anchor", strength),
        bearings.bearing(machine.free, "free", strength),
        air.surface(machine.air, strength, bearings.cover(machine.anchor) + bearings.cover(machine.free)),
        OMEGA_20,
    )


class ThermalRig:
    """The rig at one instant; `tick` carries it over one second."""

    def __init__(self, machine: Machine, strength: Strengths, weather: Weather, heaters: Heaters) -> None:
        self.machine = machine
        self.weather = weather
        self.heaters = heaters
        self.parts = parts(machine, strength)
        layer = np.full(screw.CELLS, weather.start)
        self.now = Temperatures(layer.copy(), layer.copy(), np.array([*[weather.start] * 3, 1.0, *[weather.start] * 3]))
        self.torque = np.zeros(2)
        self.since_stop_s, self.since_start_s = -1.0, 0.0
        self.later: tuple[float, Strengths, Heaters] | None = None

    def change(self, at_s: float, strength: Strengths, heaters: Heaters) -> None:
        """From a time on effects have other strengths."""
        self.later = at_s, strength, heaters

    def tick(self, t: float, motion: TableMotion) -> None:
        """From t to t + 1 s, with the table's motion at the middle of each step."""
        if self.later is not None and t >= self.later[0]:
            _, strength, self.heaters = self.later
            self.parts, self.later = parts(self.machine, strength), None
        unseen = self.weather.unseen(t)
        around = Around(
            along=self.weather.air_along(t),
            air=self.weather.ambient(t) + unseen,
            base=self.weather.base(t) + unseen,
            sources=self.heaters.heat(motion.omega, motion.moving, self.since_stop_s, self.since_start_s),
        )
        self._watch(motion)
        centres = nut.in_cells(nut_centre_mm(motion.position_mm) + self.machine.nut.offset)
        self.torque = advance(self.parts, self.now, motion.omega, centres, around)

    def _watch(self, motion: TableMotion) -> None:
        """Count the seconds since the table last moved, and since it set off."""
        if motion.moving.any():
            self.since_stop_s, self.since_start_s = 0.0, self.since_start_s + 1.0
        else:
            self.since_stop_s += float(self.since_stop_s >= 0.0)
            self.since_start_s = 0.0

    @property
    def mean(self) -> np.ndarray:
        """Mean of the layers at every cell, degC: (CELLS,)"""
        return screw.mean_temperature(self.now.bore, self.now.outer)

    @property
    def at_channels(self) -> np.ndarray:
        """Wall at the tips of the channels, degC: (15,)"""
        wall = self.now.bore + self.machine.sensors.depth * (self.now.outer - self.now.bore)
        return np.interp(CHANNEL_MM, screw.CELL_MM, wall)

    @property
    def nut(self) -> float:
        """What the nut's thermometer stands on, degC"""
        return float(self.now.bodies[6 if self.parts.nut.to_flange > 0.0 else 0])

    @property
    def brackets(self) -> tuple[float, float]:
        """What the brackets' thermometers stand on at anchor and free bearing, degC"""
        anchor, free = (4, 5) if self.parts.anchor.to_bracket > 0.0 else (1, 2)
        return self.now.bodies[anchor], self.now.bodies[free]

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
