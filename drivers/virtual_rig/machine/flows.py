"""Every flow of heat on the rig, as compiled explicit steps.

At 2.5 mm and 50 ms the steps are far inside the stability limit (0.25 s), so that the non-linear laws and the moving
contact of the nut are written as they are. All compiled code stands in this one file because the compiler's cache
notices a change only in the file of the function that is called; the values of the laws live with their parts.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

STEFAN_BOLTZMANN = 5.67e-8
KELVIN = 273.15


class Screw(NamedTuple):
    """Per cell: conductances along each layer and between them (W/K), capacities (J/K)."""

    along_bore: float
    along_outer: float
    across: float
    bore_capacity: float
    outer_capacity: float


class Nut(NamedTuple):
    """Laws of the nut, SI units; its length in cells, `start` degC."""

    torque: float
    into_screw: float
    contact: float
    to_table: float
    capacity: float
    thinning: float
    exponent: float
    churning: float
    decay_s: float
    recovery_s: float
    start: float
    length: float


class Bearing(NamedTuple):
    """One support: seat (weights of the cells under the ring, sum 1), laws in SI units, `start` degC."""

    seat: np.ndarray
    load_torque: float
    viscous_torque: float
    into_screw: float
    contact: float
    capacity: float
    to_base: float
    to_air: float
    thinning: float
    exponent: float
    start: float


class Surface(NamedTuple):
    """Area of each cell that meets the air (m2) and its laws."""

    area: np.ndarray
    still: float
    rotating: float
    exponent: float
    emissivity: float


class Parts(NamedTuple):
    """The laws of everything that passes heat; `reference`: the speed to which all speed laws refer, rad/s"""

    screw: Screw
    nut: Nut
    anchor: Bearing
    free: Bearing
    surface: Surface
    reference: float


class Temperatures(NamedTuple):
    """degC: both layers of the screw (CELLS,); bodies (4,): nut, anchor and free housing, and the grease's freshness"""

    bore: np.ndarray
    outer: np.ndarray
    bodies: np.ndarray


class Around(NamedTuple):
    """Surroundings of one tick: air along the screw (CELLS,), air and base (degC), planted heat (CELLS,) W"""

    along: np.ndarray
    air: float
    base: float
    sources: np.ndarray


@njit(cache=True)
def advance(parts: Parts, now: Temperatures, omegas: np.ndarray, centres: np.ndarray, around: Around) -> np.ndarray:
    """Carry all temperatures over one second in len(omegas) steps; the mean torques of nut and bearings, N m: (2,)"""
    dt = 1.0 / omegas.size
    cover, heat, torque = np.zeros(now.outer.size), np.zeros(now.outer.size), np.zeros(2)
    for k in range(omegas.size):
        omega, speed = omegas[k], omegas[k] / parts.reference
        heat[:] = around.sources
        lay(parts.nut, centres[k], cover)
        cool(parts.surface, speed, now.outer, cover, around.along, heat)
        torque[0] += dt * rub(parts.nut, speed, omega, now, cover, around, heat, dt)
        torque[1] += dt * turn(parts.anchor, speed, omega, now, 1, around, heat, dt)
        torque[1] += dt * turn(parts.free, speed, omega, now, 2, around, heat, dt)
        spread(parts.screw, now.bore, now.outer, heat, dt)
    return torque


@njit(cache=True)
def spread(screw: Screw, bore: np.ndarray, outer: np.ndarray, heat: np.ndarray, dt: float) -> None:
    """Carry both layers over one step; `heat` (W per cell) enters the outer one, the ends pass none.

    C dT/dt = kA/dx (T_left - 2 T + T_right) + g (T_other - T) + q
    """
    bore_in = outer_in = 0.0
    for i in range(bore.size):
        across = screw.across * (outer[i] - bore[i])
        bore_out = screw.along_bore * (bore[i] - bore[i + 1]) if i + 1 < bore.size else 0.0
        outer_out = screw.along_outer * (outer[i] - outer[i + 1]) if i + 1 < bore.size else 0.0
        bore[i] += dt / screw.bore_capacity * (bore_in - bore_out + across)
        outer[i] += dt / screw.outer_capacity * (outer_in - outer_out - across + heat[i])
        bore_in, outer_in = bore_out, outer_out


@njit(cache=True)
def lay(nut: Nut, centre: float, cover: np.ndarray) -> None:
    """Fill `cover` with the share of each cell that lies under the nut."""
    cover[:] = 0.0
    low, high = centre - nut.length / 2.0, centre + nut.length / 2.0
    for i in range(int(low), int(high) + 1):
        cover[i] = min(high, i + 1.0) - max(low, float(i))


@njit(cache=True)
def weighted(weights: np.ndarray, values: np.ndarray) -> float:
    """sum of w_i v_i"""
    total = 0.0
    for i in range(values.size):
        total += weights[i] * values[i]
    return total


@njit(cache=True)
def rub(nut: Nut, speed: float, omega: float, now: Temperatures, cover, around: Around, heat, dt) -> float:
    """One step of the nut's contact; returns its torque, N m

    M = M_preload speed^n (1 + churning fresh) exp(-thinning (T_film - T_start))
    screw: q_i = (s M omega + g (T_nut - T_i)) w_i,  w_i the cell's share of the nut's length
    body:  C dT/dt = (1 - s) M omega - g (T_nut - mean T_i) - g_table (T_nut - T_air)
    fresh: 1 after a long rest, decays while the nut moves, recovers while it stands
    """
    body, fresh = now.bodies[0], now.bodies[3]
    under = weighted(cover, now.outer) / nut.length
    thin = np.exp(-nut.thinning * (0.5 * (body + under) - nut.start))
    friction = nut.torque * (1.0 + nut.churning * fresh) * thin
    torque = friction * speed**nut.exponent if omega > 0.0 else 0.0
    for i in range(heat.size):
        heat[i] += (nut.into_screw * torque * omega + nut.contact * (body - now.outer[i])) * cover[i] / nut.length
    gain = (1.0 - nut.into_screw) * torque * omega - nut.contact * (body - under)
    now.bodies[0] += dt / nut.capacity * (gain - nut.to_table * (body - around.air))
    now.bodies[3] += dt * (-fresh / nut.decay_s if omega > 0.0 else (1.0 - fresh) / nut.recovery_s)
    return torque


@njit(cache=True)
def turn(bearing: Bearing, speed: float, omega: float, now: Temperatures, body: int, around: Around, heat, dt) -> float:
    """One step of a support whose housing is bodies[body]; returns its torque, N m

    M = (M1 + M0 speed^(2/3)) speed^n exp(-thinning (T_ring - T_start)), Palmgren; n = 0, thinning = 0 in the base rig
    seat:    q_i = (s M omega + g (T_housing - T_i)) w_i
    housing: C dT/dt = (1 - s) M omega - g (T_housing - mean T_i) - g_base (T_housing - T_base) - g_air (...)
    """
    housing = now.bodies[body]
    under = weighted(bearing.seat, now.outer)
    thin = np.exp(-bearing.thinning * (0.5 * (under + housing) - bearing.start))
    palmgren = bearing.load_torque + bearing.viscous_torque * speed ** (2.0 / 3.0)
    torque = palmgren * speed**bearing.exponent * thin if omega > 0.0 else 0.0
    for i in range(heat.size):
        heat[i] += (bearing.into_screw * torque * omega + bearing.contact * (housing - now.outer[i])) * bearing.seat[i]
    gain = (1.0 - bearing.into_screw) * torque * omega - bearing.contact * (housing - under)
    gain -= bearing.to_base * (housing - around.base) + bearing.to_air * (housing - around.air)
    now.bodies[body] += dt / bearing.capacity * gain
    return torque


@njit(cache=True)
def cool(surface: Surface, speed: float, outer: np.ndarray, cover: np.ndarray, along: np.ndarray, heat) -> None:
    """q_i = -[h_still + h_rot speed^m] A (T - T_air) - eps sigma A (T^4 - T_air^4)   W, where no nut covers it"""
    h = surface.still + surface.rotating * speed**surface.exponent
    for i in range(heat.size):
        warm, cold = outer[i] + KELVIN, along[i] + KELVIN
        radiated = surface.emissivity * STEFAN_BOLTZMANN * (warm * warm + cold * cold) * (warm + cold)
        heat[i] -= (h + radiated) * (outer[i] - along[i]) * surface.area[i] * (1.0 - cover[i])
