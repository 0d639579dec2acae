"""Heat that the screw's surface loses to the air and to the walls, where neither nut nor bearing hides it."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np

from estimator.effect import Effect, Param, needed
from estimator.inputs.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import SCREW, Heat, Link, Term

STEFAN_BOLTZMANN = 5.67e-8  # W/(m2 K4)
ROOM_K = 295.0
USUAL_K, TINY = 4.0, 1e-9  # rise of a screw in use; of it, that powers of nothing are numbers


class StillAir(Effect):
    """Heat the screw's surface loses to the air while it stands still: free convection and radiation together.

    q = h A (T - T_air)
    """

    trace = "Everywhere, at rest and while driving; in proportion to how warm the screw is."
    h = Param(8.0, "W/(m2 K)", lo=0.0, hi=100.0, null=0.0, sd=2.5, source="7.8 - 8.4 measured on bare rods")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        yield Link(SCREW, "ambient", p.h * rig.the_screw().surface, over=u.bare)


class FreeConvection(Effect):
    """Still air takes more than in proportion to how warm the screw is, for what is warmer drives it faster.

    q = h A dT ((dT / 4 K)^n - 1), dT = T - T_air, h of still_air, about w, how warm the screw is on the whole:

    at rest          h A (r ((1 + n) dT - n w) - dT), r = (w / 4 K)^n: its tangent at dT = w
    while it turns   h A w (r - 1), everywhere alike: its own wind outweighs what is left

    beside still_air, which is in proportion; fitted, and never searched for: n has no null
    """

    scales = ("still_air",)
    trace = "Everywhere at rest: too warm at first after a stop and too cold at last, the more the warmer the place."
    n = Param(0.12, "1", lo=-0.2, hi=0.5, sd=0.1, source="Nu ~ (Gr Pr)^(1/4) of what is half radiation")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        hA, rests = needed(p, "still_air").h * rig.the_screw().surface, np.asarray(u.rest_K) > 0
        yield Link(SCREW, "ambient", hA * ((1.0 + p.n) * self._law(u.rest_K, p.n) - 1.0) * rests, over=u.bare)
        w = np.where(rests, u.rest_K, u.motion.warmth)
        q = hA * w * np.where(rests, p.n * self._law(w, p.n), 1.0 - self._law(w, p.n))
        yield Heat(SCREW, q, over=1.0 - np.asarray(u.seats))
        yield Heat(SCREW, -q, over=u.coverage)

    @staticmethod
    def _law(w: Any, n: Any) -> Any:
        return np.maximum(np.asarray(w) / USUAL_K, TINY) ** n


class RotatingConvection(Effect):
    """Extra heat the surface loses to the air because the screw turns.

    q = h |omega / omega_ref|^m A (T - T_air), the mean over a minute of motion, waits included
    """

    trace = "Everywhere; too warm while driving and right at rest, the more the faster it turns."
    h = Param(20.0, "W/(m2 K)", lo=0.0, hi=500.0, null=0.0, sd=12.0, source="18 - 53 at 1667 rpm, by correlation")
    m = Param(0.67, "1", lo=0.3, hi=1.2, sd=0.08, source="rotating cylinder, Nu ~ Re^(2/3)")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        h = p.h * u.air_law(rig.the_screw(), p.m)
        yield Link(SCREW, "ambient", h * rig.the_screw().surface, over=u.bare)


class Radiation(Effect):
    """The screw's surface radiates to the walls of the room, which are as warm as the air.

    q = 4 emissivity sigma T_room^3 A (T - T_air), T_room = 295 K: the fourth power, within 4 % for 8 K of difference
    """

    trace = "As still air: below 20 K of difference nothing tells one from the other."
    emissivity = Param(0.5, "1", lo=0.0, hi=1.0, null=0.0, source="0.2 ground steel ... 0.9 oily or painted")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        h = 4.0 * p.emissivity * STEFAN_BOLTZMANN * ROOM_K**3
        yield Link(SCREW, "ambient", h * rig.the_screw().surface, over=u.bare)
