"""Two effects of the heated rod that no catalogue has."""

from estimator.effect import Effect, Param
from estimator.terms import SCREW, Heat, Link


class Heater(Effect):
    """A heater of known power warms the first 30 mm of the rod.

    q = share P
    """

    share = Param(1.0, "1", lo=0.0, hi=1.2, null=0.0, source="what the leads do not take away")

    def terms(self, p, u, rig):
        under = rig.screw.overlap(0.0, 30.0)
        yield Heat(SCREW, p.share * u["heater"] * under / under.sum())


class ChilledEnd(Effect):
    """A chilled block takes heat out of the far end.

    q = g (T_end - T_chiller)
    """

    g = Param(0.5, "W/K", lo=0.0, hi=20.0, null=0.0, source="a clamped joint with paste, by fit")

    def terms(self, p, u, rig):
        yield Link(SCREW, "chiller", p.g * rig.screw.at(rig.screw.to_mm))
