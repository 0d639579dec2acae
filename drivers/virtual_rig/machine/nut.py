"""The nut: a moving contact that rubs on the screw, with a body of its own that stores half of the heat."""

import numpy as np

from drivers.virtual_rig.machine.flows import Nut
from drivers.virtual_rig.machine.geometry import NUT_LENGTH_MM, SCREW_MM
from drivers.virtual_rig.machine.planted import Strengths
from drivers.virtual_rig.machine.screw import CELL_M

DRAG_TORQUE = 0.68  # N m from 2.2 kN of preload, independent of speed: 15 / 30 / 59 / 119 W at the four speeds
SHARE_INTO_SCREW = 0.48
CONTACT = 3.0  # W/K between nut body and the screw under it: greased balls under load
CAPACITY = 1200.0  # J/K
TO_TABLE = 0.5  # W/K from the body to the table and the air around it, both at ambient temperature
THINNING = 0.031  # 1/K, loss of friction of a VG100 grease oil with temperature
SPEED_EXPONENT = 0.2  # added to Q ~ omega^1 by nut_speed_exponent; the heat at 20 m/min stays
CHURNING = 0.4  # extra friction of fresh grease at the start of a drive
CHURNING_DECAY_S = 600.0
CHURNING_RECOVERY_S = 900.0


def nut(strength: Strengths, start_degc: float) -> Nut:
    """The nut at the given strengths of its effects."""
    return Nut(
        torque=DRAG_TORQUE * strength["nut_friction"],
        into_screw=SHARE_INTO_SCREW,
        contact=CONTACT * strength["nut_body"],
        to_table=TO_TABLE,
        capacity=CAPACITY,
        thinning=THINNING * strength["friction_thinning"],
        exponent=SPEED_EXPONENT * strength["nut_speed_exponent"],
        churning=CHURNING * strength["churning"],
        decay_s=CHURNING_DECAY_S,
        recovery_s=CHURNING_RECOVERY_S,
        start=start_degc,
        length=NUT_LENGTH_MM * 1e-3 / CELL_M,
    )


def in_cells(x_mm: np.ndarray) -> np.ndarray:
    """A place in mm as a distance from the screw's free end, in cells."""
    return (x_mm - SCREW_MM[0]) * 1e-3 / CELL_M
