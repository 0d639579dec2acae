"""What the servo drive says: position, speed, and the current that turns the screw against friction and inertia."""

from typing import NamedTuple

import numpy as np

from drivers.virtual_rig.machine.geometry import LEAD_MM
from drivers.virtual_rig.machine.motion import TableMotion

TORQUE_PER_AMPERE = 0.6  # N m/A
INERTIA = 5.6e-3  # kg m2: motor, screw and 200 kg of table behind a 12 mm lead
NOISE_A = 0.03


class DriveSignals(NamedTuple):
    """The drive's own signals, each (n,)"""

    time_s: np.ndarray
    position_mm: np.ndarray
    speed_rpm: np.ndarray
    current_a: np.ndarray
    moving: np.ndarray


def drive_signals(
    time_s: np.ndarray, motion: TableMotion, friction: np.ndarray, draw: np.random.Generator
) -> DriveSignals:
    """I = (M_friction sign(omega) + J d omega/dt) / k   A: (n,)"""
    turn = 2.0 * np.pi / LEAD_MM
    torque = friction * np.sign(motion.velocity_mm_s) + INERTIA * turn * motion.acceleration_mm_s2
    current = torque / TORQUE_PER_AMPERE + NOISE_A * draw.standard_normal(friction.shape)
    return DriveSignals(time_s, motion.position_mm, motion.speed_rpm, current, motion.moving)
