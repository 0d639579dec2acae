"""How the screw is held along its axis."""

from collections.abc import Iterator
from types import SimpleNamespace

from estimator.effect import Effect, Param
from estimator.errors import SetupError
from estimator.inputs.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import Hold, Term


class HeldEnds(Effect):
    """The free bearing holds the screw along its axis as the anchor bearing does: its ends stay, its middle moves.

    N = G / (1 / k_anchor + 1 / k_free + L / (E A)),   growth of [a, b] = free growth - N |[a, b] in L| / (E A)

    G    growth between the bearings, L apart, were the screw free there; A its cross-section; N the force it meets with
    nut  moves by the growth between it and the anchor bearing, which gives way outwards by N / k_anchor

    The stretch that it was mounted with drops out for as long as both bearings push and pull.
    """

    trace = "The elongation alone: what lies between the bearings grows by half or less of what its temperatures say."
    k_anchor = Param(1000.0, "N/um", lo=10.0, hi=1e5, sd=400.0, source="pairs of thrust bearings, bore 25 - 40 mm")
    k_free = Param(1000.0, "N/um", lo=0.0, hi=1e5, sd=400.0, source="likewise; a bearing that slides has 0")
    E = Param(206.0, "GPa", lo=50.0, hi=500.0, fixed=True, source="steel")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        anchor, free = rig.the_support("anchor").at_mm, rig.the_support("free").at_mm
        if anchor == free:
            raise SetupError(f"needs two bearings apart, but {rig.name} has both at {free:g} mm; see [supports]")
        screw_um_N = abs(anchor - free) * 1e-3 / (p.E * 1e9 * rig.the_screw().area) * 1e6
        force_N_um = p.k_free / (1.0 + p.k_free * (1.0 / p.k_anchor + screw_um_N))
        yield Hold(anchor, free, squeeze=force_N_um * screw_um_N, give=force_N_um / p.k_anchor)
