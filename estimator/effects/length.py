"""What the displacement probes make of the screw's growth."""

from collections.abc import Iterator
from types import SimpleNamespace

from estimator.effect import Effect, Param
from estimator.inputs.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import ELONGATION, SCREW, START, Expand, Read, Spot, Term

NAME = "displacement"


class Displacement(Effect):
    """The probes read the growth of the measured span, and their own and the bar's expansion.

    y = elongation + probe (T_probe - T_probe(0)) - bar (T_bar - T_bar(0)) + zero

    The zero is unknown, since the peak hold of the turning screw has no reading at rest to compare with.
    """

    trace = "None of its own: without it no elongation is read."
    sd = Param(0.15, "um", lo=0.01, hi=5.0, fixed=True, source="0.1 um scatter, hold error up to 0.19 um")
    probe = Param(0.3, "um/K", lo=0.0, hi=50.0, sd=0.15, source="at most 0.6 um in a run")
    bar = Param(0.4, "um/K", lo=0.0, hi=50.0, sd=0.2, source="super Invar, 0 - 1e-6 1/K over 0.94 m; at most 0.8 um")
    zero_sd = Param(100.0, "um", lo=0.0, hi=1000.0, fixed=True, source="disc wobble")
    zero_walk = Param(0.002, "um/sqrt(s)", lo=0.0, hi=0.1, fixed=True, source="tuned")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        offset = p.probe * u.rise("probe") - p.bar * u.rise("bar")
        yield Read(NAME, {ELONGATION: 1.0}, p.sd, offset, zero_sd=p.zero_sd, zero_walk=p.zero_walk)


class ExpansionError(Effect):
    """The screw expands by another coefficient than the rig file's.

    rho = rho_rig (1 + error)
    """

    trace = "The elongation alone, in proportion to itself; the temperatures are right."
    error = Param(0.0, "1", lo=-0.2, hi=0.2, null=0.0, sd=0.03, source="11.2 - 12.3e-6 1/K for SCM420")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        yield Expand(p.error)


class SupportYield(Effect):
    """The bracket that holds a probe moves as the anchor bearing warms.

    y = elongation + rate (T_anchor - T_start)
    """

    trace = "The elongation alone; follows the anchor bearing's temperature, alike for long and short strokes."
    rate = Param(0.5, "um/K", lo=-50.0, hi=50.0, null=0.0, sd=1.0, source="50 mm of steel bracket: 0.6 um/K")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        anchor = rig.the_support("anchor").at_mm
        yield Read(NAME, {SCREW: Spot(anchor, p.rate)}, 0.0, -p.rate * u[START])


class ProbeExpansion(Effect):
    """The probes expand more than the effect `displacement` says.

    y = elongation + rate (T_probe - T_probe(0))
    """

    trace = "The elongation alone, in step with the probes' temperature."
    rate = Param(0.8, "um/K", lo=-50.0, hi=50.0, null=0.0, sd=1.0, source="up to 0.6 um in a run")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        u["probe"]
        yield Read(NAME, {}, 0.0, p.rate * u.rise("probe"))


class BarExpansion(Effect):
    """The bar that holds the probes expands more than the effect `displacement` says.

    y = elongation - rate (T_bar - T_bar(0))
    """

    trace = "The elongation alone, in step with the bar's temperature, against its sign."
    rate = Param(
        0.9, "um/K", lo=-50.0, hi=50.0, null=0.0, sd=1.0, source="super Invar 0.5e-6 1/K, steel 11e-6 1/K over 0.94 m"
    )

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        u["bar"]
        yield Read(NAME, {}, 0.0, -p.rate * u.rise("bar"))
