"""Every flow of heat on the rig, as compiled explicit steps; 2.5 mm and 50 ms are far inside the stability limit.

All compiled code stands in this one file because the compiler's cache notices a change only in the file of the function
that is called; the values of the laws live with their parts.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

STEFAN_BOLTZMANN, KELVIN = 5.67e-8, 273.15
Array = np.ndarray


class Screw(NamedTuple):
    """Per cell: conductances along each layer and between them (W/K), capacities (J/K)."""

    along_bore: float
    along_outer: float
    across: float
    bore_capacity: float
    outer_capacity: float


class Nut(NamedTuple):
    """Laws of the nut, SI units; its length in cells, `grease_degc` its torque's; to_flange 0: one lump."""

    torque: float
    into_screw: float
    contact: float
    contact_growth: float
    to_table: float
    capacity: float
    to_flange: float
    flange_capacity: float
    thinning: float
    exponent: float
    churning: float
    decay_s: float
    recovery_s: float
    grease_degc: float
    length: float


class Bearing(NamedTuple):
    """One support: seat (weights of cells under the ring, sum 1), SI units; to_bracket 0: one lump."""

    seat: Array
    load_torque: float
    viscous_torque: float
    load_exponent: float
    viscous_exponent: float
    into_screw: float
    contact: float
    capacity: float
    to_bracket: float
    bracket_capacity: float
    to_base: float
    to_air: float
    thinning: float
    exponent: float
    grease_degc: float


class Surface(NamedTuple):
    """Area of each cell that meets the air (m2) and its laws."""

    area: Array
    still: float
    growth: float
    rise: float
    rotating: float
    exponent: float
    threshold: float
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
    """degC: layers of the screw (CELLS,); bodies (7,): nut, housings or rings, grease's freshness, brackets, flange"""

    bore: Array
    outer: Array
    bodies: Array


class Around(NamedTuple):
    """Surroundings of one tick: air along the screw (CELLS,), air and base (degC), planted heat (CELLS,) W"""

    along: Array
    air: float
    base: float
    sources: Array


@njit(cache=True)
def advance(parts: Parts, now: Temperatures, omegas: Array, centres: Array, around: Around) -> Array:
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
def spread(screw: Screw, bore: Array, outer: Array, heat: Array, dt: float) -> None:
    """Carry both layers over a step; `heat` (W per cell) enters the outer one, the ends pass none.

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
def lay(nut: Nut, centre: float, cover: Array) -> None:
    """Fill `cover` with the share of each cell that lies under the nut."""
    cover[:] = 0.0
    low, high = centre - nut.length / 2.0, centre + nut.length / 2.0
    for i in range(int(low), int(high) + 1):
        cover[i] = min(high, i + 1.0) - max(low, float(i))


@njit(cache=True)
def rub(
    nut: Nut, speed: float, omega: float, now: Temperatures, cover: Array, around: Around, heat: Array, dt: float
) -> float:
    """One step of the nut's contact; returns its torque, N m

    M = M_preload speed^n (1 + churning fresh) exp(-thinning (T_film - T_grease))
    screw: q_i = (s M omega + g (T_nut - T_i)) w_i,  w_i the cell's share of the nut's length, g = g0 (1 + k |dT|)
    body:  C dT/dt = (1 - s) M omega - g (T_nut - mean T_i) - g_table (T_nut - T_air)
    two lumps: the nut loses g_nf (T_nut - T_flange) instead, which the flange gains
    fresh: 1 after a long rest, decays while the nut moves, recovers while it stands
    """
    body, fresh = now.bodies[0], now.bodies[3]
    under = (cover * now.outer).sum() / nut.length
    thin = np.exp(-nut.thinning * (0.5 * (body + under) - nut.grease_degc))
    friction = nut.torque * (1.0 + nut.churning * fresh) * thin
    torque = friction * speed**nut.exponent if omega > 0.0 else 0.0
    contact = nut.contact * (1.0 + nut.contact_growth * abs(body - under))
    heat += (nut.into_screw * torque * omega + contact * (body - now.outer)) * cover / nut.length
    gain = (1.0 - nut.into_screw) * torque * omega - contact * (body - under)
    flange = now.bodies[6] if nut.to_flange > 0.0 else body
    lost = nut.to_table * (flange - around.air)
    if nut.to_flange > 0.0:
        passed = nut.to_flange * (body - flange)
        now.bodies[6] += dt / nut.flange_capacity * (passed - lost)
        lost = passed
    now.bodies[0] += dt / nut.capacity * (gain - lost)
    now.bodies[3] += dt * (-fresh / nut.decay_s if omega > 0.0 else (1.0 - fresh) / nut.recovery_s)
    return torque


@njit(cache=True)
def turn(
    bearing: Bearing, speed: float, omega: float, now: Temperatures, body: int, around: Around, heat: Array, dt: float
) -> float:
    """One step of a support whose housing is bodies[body]; returns its torque, N m

    M = (M1 speed^a + M0 speed^b) speed^n exp(-thinning (T_ring - T_grease)); Palmgren: a = 0, b = 2/3, n = 0
    seat:    q_i = (s M omega + g (T_housing - T_i)) w_i
    housing: C dT/dt = (1 - s) M omega - g (T_housing - mean T_i) - g_base (T_housing - T_base) - g_air (...)
    two lumps: the ring loses g_rb (T_ring - T_bracket) instead, which the bracket gains
    """
    housing = now.bodies[body]
    under = (bearing.seat * now.outer).sum()
    thin = np.exp(-bearing.thinning * (0.5 * (under + housing) - bearing.grease_degc))
    law = bearing.load_torque * speed**bearing.load_exponent + bearing.viscous_torque * speed**bearing.viscous_exponent
    torque = law * speed**bearing.exponent * thin if omega > 0.0 else 0.0
    heat += (bearing.into_screw * torque * omega + bearing.contact * (housing - now.outer)) * bearing.seat
    gain = (1.0 - bearing.into_screw) * torque * omega - bearing.contact * (housing - under)
    bracket = now.bodies[3 + body] if bearing.to_bracket > 0.0 else housing
    lost = bearing.to_base * (bracket - around.base) + bearing.to_air * (bracket - around.air)
    if bearing.to_bracket > 0.0:
        passed = bearing.to_bracket * (housing - bracket)
        now.bodies[3 + body] += dt / bearing.bracket_capacity * (passed - lost)
        lost = passed
    now.bodies[body] += dt / bearing.capacity * (gain - lost)
    return torque


@njit(cache=True)
def cool(surface: Surface, speed: float, outer: Array, cover: Array, along: Array, heat: Array) -> None:
    """q_i = -[h_still + h_rot s^m] A (T - T_air) - eps sigma A (T^4 - T_air^4)   W off the nut; s from a threshold

    h_still (|T - T_air| / rise)^growth of each place where still air takes more of what is warmer
    """
    above = max(speed - surface.threshold, 0.0) / (1.0 - surface.threshold)
    still = np.full(outer.size, surface.still)
    if surface.growth > 0.0:
        still *= (np.abs(outer - along) / surface.rise) ** surface.growth
    h = still + surface.rotating * above**surface.exponent
    warm, cold = outer + KELVIN, along + KELVIN
    radiated = surface.emissivity * STEFAN_BOLTZMANN * (warm * warm + cold * cold) * (warm + cold)
    heat -= (h + radiated) * (outer - along) * surface.area * (1.0 - cover)


@njit(cache=True)
def recall(keep: float, now: float, before: float, x: Array) -> Array:
    """y[k] = keep y[k - 1] + now x[k] + before x[k - 1], from nothing on: (n,)"""
    y, rest = np.empty_like(x), 0.0
    for k in range(len(x)):
        y[k] = now * x[k] + rest
        rest = before * x[k] + keep * y[k]
    return y
