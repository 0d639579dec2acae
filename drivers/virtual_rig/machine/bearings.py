"""The two support bearings: friction on their seats, and housings that pass the heat on to the machine's base."""

import numpy as np

from drivers.virtual_rig.machine.flows import Bearing
from drivers.virtual_rig.machine.geometry import ANCHOR_BEARING_MM, FREE_BEARING_MM
from drivers.virtual_rig.machine.planted import Strengths
from drivers.virtual_rig.machine.screw import overlap

LOAD_TORQUE = 0.0745
"""N m, Palmgren's M1 of a bearing pair: independent of speed"""
VISCOUS_TORQUE = 0.1605
"""N m at 20 m/min, Palmgren's M0 of a pair: grows with omega^(2/3); with M1: 2.5 / 6 / 15 / 41 W at the four speeds"""
THINNING = 0.042
"""1/K"""
SPEED_EXPONENT = 0.25
"""added by bearing_speed_exponent; the heat at 20 m/min stays"""
SHARE_INTO_SCREW = 0.65
HOUSING_TO_AIR = 0.5
"""W/K"""
ANCHOR_CONTACT, FREE_CONTACT = 1.6, 1.0
"""W/K between seat and housing"""
ANCHOR_TO_BASE, FREE_TO_BASE = 8.0, 5.0
"""W/K from the housing through its bracket"""
ANCHOR_CAPACITY, FREE_CAPACITY = 3500.0, 2200.0
"""J/K of the housings"""
FREE_LOAD = 0.7
"""torque of the free bearing against that of a pair"""


def seat(centre_mm: float, width_mm: float) -> np.ndarray:
    """Weights of the cells under the inner ring, sum 1: (CELLS,)"""
    share = overlap(centre_mm - width_mm / 2.0, centre_mm + width_mm / 2.0)
    return share / share.sum()


ANCHOR_WIDTH_MM = 30.0
FREE_WIDTH_MM = 20.0
SEATS = overlap(ANCHOR_BEARING_MM - ANCHOR_WIDTH_MM / 2, ANCHOR_BEARING_MM + ANCHOR_WIDTH_MM / 2) + overlap(
    FREE_BEARING_MM - FREE_WIDTH_MM / 2, FREE_BEARING_MM + FREE_WIDTH_MM / 2
)
"""Share of each cell that a bearing hides from the air."""


def anchor_bearing(strength: Strengths, start_degc: float) -> Bearing:
    """An angular-contact pair in a heavy bracket."""
    return Bearing(
        seat=seat(ANCHOR_BEARING_MM, ANCHOR_WIDTH_MM),
        load_torque=LOAD_TORQUE * strength["anchor_friction"],
        viscous_torque=VISCOUS_TORQUE * strength["anchor_friction"],
        into_screw=SHARE_INTO_SCREW,
        contact=ANCHOR_CONTACT * strength["anchor_housing"],
        capacity=ANCHOR_CAPACITY,
        to_base=ANCHOR_TO_BASE,
        to_air=HOUSING_TO_AIR,
        thinning=THINNING * strength["friction_thinning"],
        exponent=SPEED_EXPONENT * strength["bearing_speed_exponent"],
        start=start_degc,
    )


def free_bearing(strength: Strengths, start_degc: float) -> Bearing:
    """A lighter bearing in a smaller bracket."""
    return Bearing(
        seat=seat(FREE_BEARING_MM, FREE_WIDTH_MM),
        load_torque=FREE_LOAD * LOAD_TORQUE * strength["free_friction"],
        viscous_torque=FREE_LOAD * VISCOUS_TORQUE * strength["free_friction"],
        into_screw=SHARE_INTO_SCREW,
        contact=FREE_CONTACT * strength["free_housing"],
        capacity=FREE_CAPACITY,
        to_base=FREE_TO_BASE,
        to_air=HOUSING_TO_AIR,
        thinning=THINNING * strength["friction_thinning"],
        exponent=SPEED_EXPONENT * strength["bearing_speed_exponent"],
        start=start_degc,
    )
