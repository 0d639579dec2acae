"""The two support bearings: friction on their seats, and housings that pass the heat on to the machine's base."""

from typing import NamedTuple

import numpy as np

from drivers.virtual_rig.machine.flows import Bearing
from drivers.virtual_rig.machine.geometry import ANCHOR_BEARING_MM, FREE_BEARING_MM
from drivers.virtual_rig.machine.planted import Strengths
from drivers.virtual_rig.machine.screw import overlap

LOAD_TORQUE = 0.0745  # N m, Palmgren's M1 of a bearing pair: independent of speed
# N m at 20 m/min, Palmgren's M0 of a pair: grows with omega^(2/3); with M1: 2.5 / 6 / 15 / 41 W at the four speeds
VISCOUS_TORQUE = 0.1605
THINNING = 0.042  # 1/K
SPEED_EXPONENT = 0.25  # added by bearing_speed_exponent; the heat at 20 m/min stays
SHARE_INTO_SCREW = 0.65
HOUSING_TO_AIR = 0.5  # W/K


class Support(NamedTuple):
    """A bearing in its bracket; the conductances lead from its housing to the seat and through the bracket."""

    name: str
    centre_mm: float
    width_mm: float
    load: float  # torque against that of a pair
    contact: float  # W/K
    to_base: float  # W/K
    capacity: float  # J/K

    @property
    def cover(self) -> np.ndarray:
        """Share of each cell under the inner ring: (CELLS,)"""
        return overlap(self.centre_mm - self.width_mm / 2.0, self.centre_mm + self.width_mm / 2.0)

    def bearing(self, strength: Strengths, start_degc: float) -> Bearing:
        """Its laws at the given strengths of its effects."""
        friction = strength[f"{self.name}_friction"]
        return Bearing(
            seat=self.cover / self.cover.sum(),
            load_torque=self.load * LOAD_TORQUE * friction,
            viscous_torque=self.load * VISCOUS_TORQUE * friction,
            into_screw=SHARE_INTO_SCREW,
            contact=self.contact * strength[f"{self.name}_housing"],
            capacity=self.capacity,
            to_base=self.to_base,
            to_air=HOUSING_TO_AIR,
            thinning=THINNING * strength["friction_thinning"],
            exponent=SPEED_EXPONENT * strength["bearing_speed_exponent"],
            start=start_degc,
        )


ANCHOR = Support("anchor", ANCHOR_BEARING_MM, 30.0, load=1.0, contact=1.6, to_base=8.0, capacity=3500.0)
FREE = Support("free", FREE_BEARING_MM, 20.0, load=0.7, contact=1.0, to_base=5.0, capacity=2200.0)
SEATS = ANCHOR.cover + FREE.cover  # share of each cell that a bearing hides from the air
