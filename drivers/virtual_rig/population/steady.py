"""How far a machine would grow if its table never stopped, as a sum of conductances: can it follow the protocol?"""

import math

from drivers.virtual_rig.machine.geometry import BORE_RADIUS_M, OMEGA_20, OUTER_RADIUS_M, SCREW_MM, SPAN_MM
from drivers.virtual_rig.population.constants import Air, Anchor, Machine, Nut

RADIATION = 5.8  # W/(m2 K), 4 sigma T^3 at 295 K
AREA_M2 = math.pi * (OUTER_RADIUS_M**2 - BORE_RADIUS_M**2)
AROUND_M = 2.0 * math.pi * OUTER_RADIUS_M


def steady_growth_um(one: Machine, speed: float) -> float:
    """Growth of the measured span at last; `speed` against 20 m/min. A fifth off at most at 2.5 m/min.

    X = rho L sum q / sum g, all of the screw equally warm but for the seats, which a fin's 2 sqrt(h P k A) joins to it
    """
    h = _film(one.air, speed)
    fin = 2.0 * math.sqrt(h * AROUND_M * one.screw.conductivity * AREA_M2)
    heat, away = _nut(one.nut, speed)
    away += h * AROUND_M * (SCREW_MM[1] - SCREW_MM[0] - one.nut.length) * 1e-3
    for support in (one.anchor, one.free):
        at_seat, from_seat = _bearing(support, speed)
        heat += at_seat * fin / (fin + from_seat)
        away += _series(fin, from_seat)
    return one.screw.expansion * (SPAN_MM[1] - SPAN_MM[0]) * 1e3 * heat / away


def _film(air: Air, speed: float) -> float:
    above = max(speed - air.threshold, 0.0) / (1.0 - air.threshold)
    return air.still + air.rotating * above**air.exponent + RADIATION * air.emissivity


def _nut(nut: Nut, speed: float) -> tuple[float, float]:
    power = nut.drag_torque * speed**nut.speed_exponent * speed * OMEGA_20
    return _left(power, nut.into_screw, nut.contact, nut.to_table)


def _bearing(support: Anchor, speed: float) -> tuple[float, float]:
    torque = support.load_torque * speed**support.power
    torque += support.viscous_torque * speed ** (support.power or 2.0 / 3.0)
    out = support.to_base + support.to_air
    out = _series(out, support.ring_to_bracket) if support.ring_to_bracket else out
    return _left(torque * speed * OMEGA_20, support.into_screw, support.contact, out)


def _left(power: float, share: float, contact: float, out: float) -> tuple[float, float]:
    """Heat that friction leaves in the screw (W), and the conductance from the screw through the body (W/K)"""
    return power * (share + (1.0 - share) * contact / (contact + out)), _series(contact, out)


def _series(*conductances: float) -> float:
    return 1.0 / sum(1.0 / g for g in conductances)
