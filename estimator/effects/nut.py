"""The nut: friction heat along its travel, and a body that parks where the table stops."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

from estimator.effect import Effect, Param, needed
from estimator.inputs.balls import Balls, ByBalls
from estimator.inputs.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import SCREW, Heat, Link, Store, Term


def per_cell(rig: Rig) -> float:
    """Share of the nut that a wholly covered cell holds: times the coverage this sums to 1 inside the screw."""
    return float(rig.the_screw().length * 1e3 / rig.the_nut().length_mm)


def under_nut(p: SimpleNamespace, u: Inputs, rig: Rig) -> Any:
    """Share of each cell under the nut, (ticks, cells), for an effect that `scales` nut_balls: under these, if any."""
    balls = getattr(p, "nut_balls", None)
    if balls is None:
        return u.coverage
    return ByBalls(u.coverage, rig, Balls(balls.shift, balls.width, balls.gap, balls.lean))


class NutBalls(Effect):
    """Balls carry on a part of the nut alone: friction heats the screw there, and heat passes to the nut.

    q ~ 1 -+ lean at gap b / 2 < |x - x_nut - shift| < b / 2, b = width L, else 0;   - below, + above the middle
    L the nut's length, x_nut its middle

    gap   of two circuits: what is left free between them
    lean  by which share the upper one carries more than both do on the mean: of two nuts that are preloaded against
          each other as well as of one that is loaded on a side

    Fitted, and never searched for: no parameter has a null
    """

    trace = "Thermometers that short strokes pass too warm and too cold side by side while driving."
    apart = True
    shift = Param(0.0, "mm", lo=-40.0, hi=40.0, sd=3.0, source="mounting, and circuits off the middle")
    width = Param(0.9, "1", lo=0.3, hi=1.1, sd=0.15, source="circuits end before seals and flange: 0.7 - 1")
    gap = Param(0.15, "1", lo=0.0, hi=0.8, sd=0.2, source="one circuit: 0; two and their returns: 0.1 - 0.4")
    lean = Param(0.0, "1", lo=-0.8, hi=0.8, sd=0.1, source="circuits of unlike load: 0.4 to 0.6 of it each")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        rig.the_nut()
        return iter(())


class NutFriction(Effect):
    """Friction of the preloaded nut heats the screw along the nut's travel, and the nut.

    q = P |omega / omega_ref|^n, spread over the cells under the nut;   q_nut = P_nut |omega / omega_ref|^n

    P      heat into the screw at the reference speed, W
    P_nut  heat into the nut, W: gone where the nut is not modelled as a body
    n      1: constant torque
    noise  scatter of q, sqrt(s): share of q, with a memory of one second
    """

    scales = ("nut_balls",)
    trace = "Wherever the nut travels the screw is too cold while driving."
    power = Param(
        60.0, "W", lo=0.0, hi=2000.0, null=0.0, sd=20.0, source="109 W at 2 kN preload and 20 m/min, 0.3 - 0.7 of it"
    )
    power_nut = Param(50.0, "W", lo=0.0, hi=2000.0, null=0.0, sd=20.0, source="the rest of the 109 W")
    n = Param(1.0, "1", lo=0.5, hi=2.0, sd=0.12, source="1.0 constant torque ... 1.67 viscous")
    noise = Param(0.3, "sqrt(s)", lo=0.0, hi=10.0, fixed=True, source="tuned")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        relative = u.speed_law(rig.the_screw(), p.n)
        into_screw, into_nut = p.power * relative * per_cell(rig), p.power_nut * relative
        yield Heat(SCREW, into_screw, over=under_nut(p, u, rig), noise=p.noise * into_screw)
        yield Heat("nut", into_nut, noise=p.noise * into_nut, spare=True)


class NutFlange(Effect):
    """The nut is two bodies: what the balls run in, which friction heats, and behind a joint its flange and bracket.

    (1 - share) C dT/dt = q_nut - g (T - T_screw) - (T - T_flange) / r      C, g and g_air of nut_body
    share C dT_flange/dt = (T - T_flange) / r - g_air (T_flange - T_air)

    What the balls run in is warmer than the rest while driving, and gives that to the screw within minutes of a stop.
    Fitted, and never searched for: no parameter has a null
    """

    trace = "After a stop heat comes back faster than a nut cools, for a minute or two, where it parks."
    scales = ("nut_body",)
    share = Param(0.5, "1", lo=0.1, hi=0.9, sd=0.15, source="flange and bracket weigh about as much as the nut")
    r = Param(0.05, "K/W", lo=0.003, hi=0.6, sd=0.06, source="10 - 20 mm of steel and a bolted joint: 0.02 - 0.2")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        nut = needed(p, "nut_body")
        yield Store("nut_flange", p.share * nut.capacity, nut.noise, start="nut")
        yield Link("nut", "nut_flange", 1.0 / p.r)
        yield Link("nut_flange", "ambient", nut.g_air)


class NutBody(Effect):
    """The nut is a body of its own: its friction heats it, and it gives heat to the screw where it is.

    C dT/dt = q_nut - g (T - T_screw) - g_air (T - T_air)      with nut_flange it is two, and the outer one has g_air
    """

    scales = ("nut_balls", "nut_flange")
    trace = "Heat comes back after the stop, where the nut parks and nowhere else."
    capacity = Param(1500.0, "J/K", lo=100.0, hi=20000.0, sd=300.0, source="1000 - 2000 computed from drawings")
    g = Param(2.0, "W/K", lo=0.0, hi=50.0, null=0.0, sd=1.0, source="0.8 - 1.6 unsealed, more with grease and load")
    g_air = Param(1.0, "W/K", lo=0.0, hi=50.0, sd=0.6, source="surface 0.05 m2, and what the table takes")
    noise = Param(5.0, "W/sqrt(Hz)", lo=0.01, hi=100.0, fixed=True, source="by coverage on simulated runs")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        flange = p.nut_flange
        capacity = p.capacity * (1.0 - flange.share) if flange else p.capacity
        yield Store("nut", capacity, p.noise, start="nut", shown=flange is None)
        yield Link(SCREW, "nut", p.g * per_cell(rig), over=under_nut(p, u, rig))
        if flange is None:
            yield Link("nut", "ambient", p.g_air)
