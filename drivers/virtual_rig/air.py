"""The screw's surface and the air: still-air and rotating convection, radiation."""

from typing import NamedTuple

import numpy as np
from numba import njit

from drivers.virtual_rig.bearings import SEATS
from drivers.virtual_rig.geometry import OMEGA_20, OUTER_RADIUS_M
from drivers.virtual_rig.planted import Strengths
from drivers.virtual_rig.screw import CELL_M

STILL_AIR = 3.6
"""W/(m2 K), natural convection of a 40 mm rod, some kelvin warmer than the air"""
ROTATING = 25.0
"""W/(m2 K) at 20 m/min on top of still air: together 10 / 13 / 19 / 29, near Jungnickel's 6.8 / 11 / 18 / 29"""
SPEED_EXPONENT = 0.7
"""Jungnickel"""
EMISSIVITY = 0.5
"""of a greasy steel surface, planted as `radiation`"""
STEFAN_BOLTZMANN = 5.67e-8


class Surface(NamedTuple):
    """Area of each cell that meets the air (m2) and its laws."""

    area: np.ndarray
    still: float
    rotating: float
    emissivity: float


def surface(strength: Strengths) -> Surface:
    """The screw's surface outside the bearings."""
    area = (1.0 - SEATS) * 2.0 * np.pi * OUTER_RADIUS_M * CELL_M
    return Surface(
        area=area,
        still=STILL_AIR * strength["still_air"],
        rotating=ROTATING * strength["rotating_convection"],
        emissivity=min(EMISSIVITY * strength["radiation"], 1.0),
    )


@njit(cache=True)
def cool(surface, omega, outer, cover, air, heat):
    """Heat lost to the air where no nut covers the screw.

    q_i = -[h_still + h_rot (omega/omega_20)^0.7] A (T - T_air) - eps sigma A (T^4 - T_air^4)   W
    """
    h = surface.still + surface.rotating * (omega / OMEGA_20) ** SPEED_EXPONENT
    sigma = surface.emissivity * STEFAN_BOLTZMANN
    for i in range(outer.size):
        rise = outer[i] - air[i]
        kelvin_sum = outer[i] + air[i] + 546.3
        squares = (outer[i] + 273.15) ** 2 + (air[i] + 273.15) ** 2
        heat[i] -= (h + sigma * kelvin_sum * squares) * rise * surface.area[i] * (1.0 - cover[i])
