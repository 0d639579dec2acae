"""One finished run: what was true, what was measured, and what the drive said."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drivers.virtual_rig.dice import dice
from drivers.virtual_rig.machine.motion import TableMotion, Travel
from drivers.virtual_rig.population.constants import Machine
from drivers.virtual_rig.sensors.drive import DriveSignals, drive_signals
from drivers.virtual_rig.sensors.environment import Environment
from drivers.virtual_rig.sensors.probes import Reading
from drivers.virtual_rig.sensors.truth import Truth


class Holds(NamedTuple):
    """Held displacement, each (m,): stroke centre, instant of the freeze (s), the reading taken at the centre."""

    centre_s: np.ndarray
    frozen_s: np.ndarray
    reading: Reading


class Measured(NamedTuple):
    """What the sensors show, one row a second: channels (n, 15) and board degC, direct displacement, environment."""

    time_s: np.ndarray
    channels: np.ndarray
    board: np.ndarray
    direct: Reading
    environment: Environment


@dataclass(frozen=True)
class Run:
    """A run of the rig; `planted` are the strengths that differ from the base rig from `onset_s` on, `places` where
    they sit."""

    name: str
    seed: int
    machine: Machine
    planted: dict[str, float]
    places: dict[str, float]
    onset_s: float
    truth: Truth
    measured: Measured
    holds: Holds
    travel: Travel

    def motion(self, time_s: np.ndarray) -> TableMotion:
        """The table's true motion at any instants."""
        return self.travel.at(np.asarray(time_s, dtype=float))

    def drive(self, time_s: np.ndarray) -> DriveSignals:
        """The drive's signals at any ascending instants; the current's noise is drawn for these instants."""
        torque = self.truth.nut_torque + self.truth.bearing_torque
        friction = np.interp(time_s, self.truth.time_s, torque)
        return drive_signals(time_s, self.motion(time_s), friction, dice(self.seed, self.name, "motor"))
