"""The nut: a moving contact that rubs on the screw, with a body of its own that stores half of the heat."""

import numpy as np

from drivers.virtual_rig.machine.flows import Nut
from drivers.virtual_rig.machine.geometry import SCREW_MM
from drivers.virtual_rig.machine.planted import Strengths
from drivers.virtual_rig.machine.screw import CELL_M
from drivers.virtual_rig.population.constants import Nut as Build

SPEED_EXPONENT = 0.2  # added to the heat's exponent by nut_speed_exponent; the heat at 20 m/min stays
CHURNING = 0.4  # extra friction of fresh grease at the start of a drive


def nut(build: Build, strength: Strengths) -> Nut:
    """The nut of a machine at the given strengths of its effects."""
    return Nut(
        torque=build.drag_torque * strength["nut_friction"],
        into_screw=build.into_screw,
        contact=build.contact * strength["nut_body"],
        contact_growth=build.contact_growth,
        to_table=build.to_table,
        capacity=build.capacity * (1.0 - build.flange_share),
        to_flange=build.to_flange,
        flange_capacity=build.capacity * build.flange_share,
        thinning=build.thinning + build.planted_thinning * strength["friction_thinning"],
        exponent=build.speed_exponent + SPEED_EXPONENT * strength["nut_speed_exponent"],
        churning=build.churning + CHURNING * strength["churning"],
        decay_s=build.churning_decay,
        recovery_s=build.churning_recovery,
        grease_degc=build.grease,
        length=build.length * 1e-3 / CELL_M,
    )


def in_cells(x_mm: np.ndarray) -> np.ndarray:
    """A place in mm as a distance from the screw's free end, in cells."""
    return (x_mm - SCREW_MM[0]) * 1e-3 / CELL_M
