"""Heat that the screw's surface loses to the air."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace

from estimator.effect import Effect, Param
from estimator.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import SCREW, Link, Term


class StillAir(Effect):
    """Heat the screw's surface loses to the air while it stands still: free convection and radiation together.

    q = h A (T - T_air)
    """

    h = Param(8.0, "W/(m2 K)", lo=0.0, hi=25.0, null=0.0, source="7.8 - 8.4 measured on bare rods")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        yield Link(SCREW, "ambient", p.h * rig.the_screw().surface)


class RotatingConvection(Effect):
    """Extra heat the surface loses to the air because the screw turns.

    q = h |omega / omega_ref|^m A (T - T_air)
    """

    h = Param(20.0, "W/(m2 K)", lo=0.0, hi=120.0, null=0.0, source="18 - 53 at 1667 rpm, by correlation")
    m = Param(0.67, "1", lo=0.4, hi=1.0, fixed=True, source="rotating cylinder, Nu ~ Re^(2/3)")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        h = p.h * rig.the_screw().relative_speed(u.omega) ** p.m
        yield Link(SCREW, "ambient", h * rig.the_screw().surface)
