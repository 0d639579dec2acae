"""What friction depends on beside a constant torque: speed, temperature, and grease that has just been at rest."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np

from estimator.effect import Effect, Param, needed
from estimator.effects.bearings import BEARINGS, SEATS, seat_of, under_bearing
from estimator.effects.nut import per_cell, under_nut
from estimator.inputs.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import SCREW, START, Heat, Link, Term

TINY = 1e-12  # (W/K)^2
WORKING_K = 10.0  # by how much what rubs is warmer than T_ref on the whole: from there on the law is straight
THINNED = ("nut_friction", "nut_body", "anchor_friction", "anchor_housing", "free_friction", "free_housing", *SEATS)


class NutSpeedExponent(Effect):
    """The nut's friction grows faster with speed than its own law says, and is the same at the reference speed.

    q = P (|omega / omega_ref|^(n + extra) - |omega / omega_ref|^n), P and n of nut_friction
    """

    scales = ("nut_friction", "nut_balls")
    trace = "None at the reference speed; at others the nut's heat is wrong, and more so the further off they are."
    extra = Param(0.2, "1", lo=-0.5, hi=0.8, null=0.0, source="0 constant torque ... 0.5 rolling ... 0.67 viscous")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        nut, screw = needed(p, "nut_friction"), rig.the_screw()
        more = u.speed_law(screw, nut.n + p.extra) - u.speed_law(screw, nut.n)
        yield Heat(SCREW, nut.power * more * per_cell(rig), over=under_nut(p, u, rig))
        yield Heat("nut", nut.power_nut * more, spare=True)


class BearingSpeedExponent(Effect):
    """The bearings' friction grows faster with speed than its own law says, and is the same at the reference speed.

    q = P (|omega / omega_ref|^(n + extra) - |omega / omega_ref|^n), P and n of anchor_friction and free_friction
    """

    scales = ("anchor_friction", "free_friction", *SEATS)
    trace = "None at the reference speed; at others the ends of the screw are too warm or too cold."
    extra = Param(0.2, "1", lo=-0.6, hi=0.8, null=0.0, source="1.0 load ... 1.67 viscous, Palmgren")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        screw = rig.the_screw()
        for support in BEARINGS:
            bearing = needed(p, f"{support}_friction")
            more = u.speed_law(screw, bearing.n + p.extra) - u.speed_law(screw, bearing.n)
            yield Heat(SCREW, bearing.power * more, over=under_bearing(rig, support, seat_of(p, support)))
            yield Heat(f"{support}_housing", bearing.power_housing * more, spare=True)


class FrictionThinning(Effect):
    """Friction of nut and bearings falls as the grease warms, and is higher on a colder day.

    q = P |omega / omega_ref|^n (e^(-rate (T - T_ref)) - 1), P and n of nut_friction, its tangent 10 K above T_ref

    reference  T_ref, at which the powers are what they are;   ratio: of the bearings' rate to that of the nut
    """

    scales = THINNED
    trace = "The curve bends early: less heat the warmer it is, whatever the time; worse for short strokes."
    rate = Param(0.03, "1/K", lo=0.0, hi=0.08, null=0.0, source="3.1 - 3.5 %/K, Vogel-Cameron for VG100 - VG220")
    ratio = Param(1.35, "1", lo=0.0, hi=3.0, fixed=True, source="bearings 4.2 %/K, Palmgren, against 3.1")
    reference = Param(22.0, "degC", lo=-50.0, hi=100.0, fixed=True, source="a workshop")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        yield from _thinned(p, u, rig, p.rate, p.rate * p.ratio)


class WarmGrease(Effect):
    """Grease is a little thinner the warmer it is: friction of nut and bearings is as told at one temperature.

    q = P |omega / omega_ref|^n (e^(-nut (T - T_ref)) - 1), P and n of nut_friction, its tangent 10 K above T_ref;
    `bearings` instead of `nut` at these

    reference  T_ref, at which the powers are what they are;   a rate is below 0 where warmth adds to the preload

    Beside friction_thinning, which is all of a grease's viscosity: of a preloaded nut's torque a part is load, and does
    not thin. Fitted, and never searched for: no parameter has a null
    """

    scales = THINNED
    trace = "The first minutes of a drive too cold and the last too warm, and more heat on a colder day."
    nut = Param(
        0.004, "1/K", lo=-0.01, hi=0.08, sd=0.004, source="0 where load brakes, 0.5 - 1.5 %/K of greased screws"
    )
    bearings = Param(
        0.004, "1/K", lo=-0.01, hi=0.08, sd=0.004, source="M1 does not thin, M0 by 2/3 of 4 %/K: 0 - 1.5 %/K"
    )
    reference = Param(22.0, "degC", lo=-50.0, hi=100.0, fixed=True, source="a workshop")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        yield from _thinned(p, u, rig, p.nut, p.bearings)


def _thinned(p: SimpleNamespace, u: Inputs, rig: Rig, nut_rate: Any, bearing_rate: Any) -> Iterator[Term]:
    """What friction that falls by these rates, 1/K, takes from its heats at T_ref."""
    w, colder = rig.the_screw().relative_speed(u.omega), p.reference - u[START]
    nut = needed(p, "nut_friction")
    # by the whole nut: in single cells the balls' share may be below 0, and a link would conduct backwards
    law, under = _tangent(nut_rate, w**nut.n, colder), (per_cell(rig), u.coverage)
    yield from _falling(law, nut.power, under)
    if p.nut_body is not None:
        yield from _beside("nut", p.nut_body.g, law, (nut.power, nut.power_nut), under)
    for support in BEARINGS:
        bearing, housing = getattr(p, f"{support}_friction"), getattr(p, f"{support}_housing")
        if bearing is None:
            continue
        law = _tangent(bearing_rate, w**bearing.n, colder)
        under = (1.0, under_bearing(rig, support, seat_of(p, support)))
        yield from _falling(law, bearing.power, under)
        if housing is not None:
            powers = (bearing.power, bearing.power_housing)
            yield from _beside(f"{support}_housing", housing.g, law, powers, under)


def _falling(law: tuple[Any, Any], power: Any, under: tuple[float, Any]) -> Iterator[Term]:
    """Of the power that goes into the screw."""
    (slope, more), (share, over) = law, under
    yield Link(SCREW, START, slope * power * share, over=over)
    yield Heat(SCREW, more * power * share, over=over)


def _beside(
    body: str, g: Any, law: tuple[Any, Any], powers: tuple[Any, Any], under: tuple[float, Any]
) -> Iterator[Term]:
    """Of the power that goes into the body beside the screw; what rubs is as warm as both on the mean.

    So each feels the other with half its own slope: a link -s, half the mean of both, here -s g^2 / (g^2 + s^2),
    which is that while s is little beside the g between them, and takes half of g at most
    """
    (slope, more), (share, over) = law, under
    yield Link(body, START, slope * powers[1])
    yield Heat(body, more * powers[1])
    less = slope * sum(powers) / 4.0
    yield Link(SCREW, body, -less * g**2 / (g**2 + less**2 + TINY) * share, over=over)


def _tangent(rate: Any, speed: Any, colder: Any) -> tuple[Any, Any]:
    """Of speed (e^(-rate (T - T_ref)) - 1): how much it falls per K, and what it is where the screw started."""
    steep = np.exp(-rate * WORKING_K)
    return speed * rate * steep, speed * (steep * (1.0 + rate * (WORKING_K + colder)) - 1.0)


class Churning(Effect):
    """Grease that has rested churns: the nut's friction is higher at the start of a drive and settles.

    q = share f P |omega / omega_ref|^n, P and n of nut_friction;   f falls with motion, and comes back at rest
    """

    scales = ("nut_friction", "nut_balls")
    trace = "The first minutes of every drive after a long rest are too cold, wherever the nut travels."
    share = Param(
        0.4, "1", lo=-0.5, hi=3.0, null=0.0, source="starting torque of greased screws, up to twice the running"
    )
    decay = Param(600.0, "s", lo=60.0, hi=3600.0, sd=200.0, source="grease runs in within minutes")
    recovery = Param(900.0, "s", lo=60.0, hi=36000.0, sd=400.0, source="grease flows back within a stop")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        nut = needed(p, "nut_friction")
        w = p.share * u.motion.freshness(p.decay, p.recovery) * u.speed_law(rig.the_screw(), nut.n)
        yield Heat(SCREW, nut.power * w * per_cell(rig), over=under_nut(p, u, rig))
        yield Heat("nut", nut.power_nut * w, spare=True)
