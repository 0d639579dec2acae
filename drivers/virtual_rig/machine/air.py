"""The screw's surface and the air: still-air and rotating convection, radiation."""

import numpy as np

from drivers.virtual_rig.machine.flows import Surface
from drivers.virtual_rig.machine.geometry import OUTER_RADIUS_M
from drivers.virtual_rig.machine.planted import Strengths
from drivers.virtual_rig.machine.screw import CELL_M
from drivers.virtual_rig.population.constants import Air

EMISSIVITY = 0.5  # of a greasy steel surface, planted as `radiation`


def surface(air: Air, strength: Strengths, seats: np.ndarray) -> Surface:
    """The screw's surface outside the bearings, which hide the share `seats` (CELLS,) of each cell from the air."""
    area = (1.0 - seats) * 2.0 * np.pi * OUTER_RADIUS_M * CELL_M
    return Surface(
        area=area,
        still=air.still * strength["still_air"],
        growth=air.growth,
        rise=air.rise,
        rotating=air.rotating * strength["rotating_convection"],
        exponent=air.exponent,
        threshold=air.threshold,
        emissivity=min(air.emissivity + EMISSIVITY * strength["radiation"], 1.0),
    )
