"""The servo motor: the current that turns the screw against friction and inertia."""

import numpy as np

from drivers.virtual_rig.machine.geometry import LEAD_MM
from drivers.virtual_rig.machine.motion import TableMotion

TORQUE_PER_AMPERE = 0.6
"""N m/A"""
INERTIA = 5.6e-3
"""kg m2: motor, screw and 200 kg of table behind a 12 mm lead"""
NOISE_A = 0.03


def current(motion: TableMotion, friction: np.ndarray, draw: np.random.Generator) -> np.ndarray:
    """I = (M_friction sign(omega) + J d omega/dt) / k   A: (n,)"""
    turn = 2.0 * np.pi / LEAD_MM
    torque = friction * np.sign(motion.velocity_mm_s) + INERTIA * turn * motion.acceleration_mm_s2
    return torque / TORQUE_PER_AMPERE + NOISE_A * draw.standard_normal(friction.shape)
