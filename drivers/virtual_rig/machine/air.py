"""The screw's surface and the air: still-air and rotating convection, radiation."""

import numpy as np

from drivers.virtual_rig.machine.bearings import SEATS
from drivers.virtual_rig.machine.flows import Surface
from drivers.virtual_rig.machine.geometry import OUTER_RADIUS_M
from drivers.virtual_rig.machine.planted import Strengths
from drivers.virtual_rig.machine.screw import CELL_M

STILL_AIR = 3.6  # W/(m2 K), natural convection of a 40 mm rod, some kelvin warmer than the air
# W/(m2 K) at 20 m/min on top of still air: together 10 / 13 / 19 / 29, near Jungnickel's 6.8 / 11 / 18 / 29
ROTATING = 25.0
SPEED_EXPONENT = 0.7  # Jungnickel
EMISSIVITY = 0.5  # of a greasy steel surface, planted as `radiation`


def surface(strength: Strengths) -> Surface:
    """The screw's surface outside the bearings."""
    area = (1.0 - SEATS) * 2.0 * np.pi * OUTER_RADIUS_M * CELL_M
    return Surface(
        area=area,
        still=STILL_AIR * strength["still_air"],
        rotating=ROTATING * strength["rotating_convection"],
        exponent=SPEED_EXPONENT,
        emissivity=min(EMISSIVITY * strength["radiation"], 1.0),
    )
