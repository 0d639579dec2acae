"""The nut: a moving contact that rubs on the screw, with a body of its own that stores half of the heat."""

from typing import NamedTuple

import numpy as np
from numba import njit

from drivers.virtual_rig.geometry import NUT_LENGTH_MM, OMEGA_20, SCREW_MM
from drivers.virtual_rig.planted import Strengths
from drivers.virtual_rig.screw import CELL_M

DRAG_TORQUE = 0.68
"""N m from 2.2 kN of preload, independent of speed: 15 / 30 / 59 / 119 W at the four speeds"""
SHARE_INTO_SCREW = 0.48
CONTACT = 3.0
"""W/K between nut body and the screw under it: greased balls under load"""
CAPACITY = 1200.0
"""J/K"""
TO_TABLE = 0.5
"""W/K from the body to the table and the air around it, both at ambient temperature"""
THINNING = 0.031
"""1/K, loss of friction of a VG100 grease oil with temperature"""
SPEED_EXPONENT = 0.2
"""added to Q ~ omega^1 by nut_speed_exponent; the heat at 20 m/min stays"""
CHURNING = 0.4
"""extra friction of fresh grease at the start of a drive"""
CHURNING_DECAY_S = 600.0
CHURNING_RECOVERY_S = 900.0


class Nut(NamedTuple):
    """Laws of the nut, SI units; positions and length in cells, counted from the screw's free end."""

    torque: float
    into_screw: float
    contact: float
    to_table: float
    capacity: float
    thinning: float
    exponent: float
    churning: float
    start: float
    length: float


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
        start=start_degc,
        length=NUT_LENGTH_MM * 1e-3 / CELL_M,
    )


def in_cells(x_mm: np.ndarray) -> np.ndarray:
    """A place in mm as a distance from the screw's free end, in cells."""
    return (x_mm - SCREW_MM[0]) * 1e-3 / CELL_M


@njit(cache=True)
def lay(nut, centre, cover):
    """Fill `cover` with the share of each cell that lies under the nut."""
    cover[:] = 0.0
    low = centre - nut.length / 2.0
    high = centre + nut.length / 2.0
    for i in range(int(low), int(high) + 1):
        cover[i] = min(high, i + 1.0) - max(low, float(i))


@njit(cache=True)
def drag(nut, omega, film, fresh):
    """M = M_preload (omega/omega_20)^n (1 + churning fresh) exp(-thinning (T_film - T_start))   N m"""
    speed = (omega / OMEGA_20) ** nut.exponent
    return nut.torque * speed * (1.0 + nut.churning * fresh) * np.exp(-nut.thinning * (film - nut.start))


@njit(cache=True)
def rub(nut, omega, outer, cover, heat, body, fresh, air, dt):
    """One step of contact: heat into the covered cells and the body; returns the body's temperature and the torque.

    screw: q_i = (s M omega + g (T_nut - T_i)) w_i,  w_i the cell's share of the nut's length
    body:  C dT/dt = (1 - s) M omega - g (T_nut - mean T_i) - g_table (T_nut - T_air)
    """
    under = 0.0
    for i in range(outer.size):
        under += cover[i] * outer[i]
    under /= nut.length
    torque = drag(nut, omega, 0.5 * (body + under), fresh) if omega > 0.0 else 0.0
    friction = torque * omega
    for i in range(outer.size):
        heat[i] += (nut.into_screw * friction + nut.contact * (body - outer[i])) * cover[i] / nut.length
    gain = (1.0 - nut.into_screw) * friction - nut.contact * (body - under) - nut.to_table * (body - air)
    return body + dt * gain / nut.capacity, torque


@njit(cache=True)
def settle(fresh, omega, dt):
    """Freshness of the grease, 1 after a long rest: decays while the nut moves, recovers while it stands."""
    if omega > 0.0:
        return fresh - dt * fresh / CHURNING_DECAY_S
    return fresh + dt * (1.0 - fresh) / CHURNING_RECOVERY_S
