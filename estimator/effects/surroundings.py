"""Air and base at the screw that are not what their thermometers show."""

from collections.abc import Iterator
from types import SimpleNamespace

from estimator.effect import Effect, Param
from estimator.errors import SetupError
from estimator.inputs.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import Shift, Term

HOUR = 3600.0


class BaseDrift(Effect):
    """Air and base at the screw drift away from their thermometers with the clock.

    T_air = T_air,measured + rate t,   T_base = T_base,measured + rate t
    """

    trace = "Uniform along the screw; follows the clock and not the duty."
    rate = Param(1.0, "K/h", lo=-5.0, hi=5.0, null=0.0, source="a machine base drifts by up to a few K in a shift")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        drift = p.rate * u.motion.time_s / HOUR
        yield from (Shift(name, drift) for name in ("ambient", "base") if name in u)


class AmbientGradient(Effect):
    """The air along the screw is warmer at one end than at the other.

    T_air(x) = T_air,measured + difference (x - x_middle) / (length between the outermost thermometers)
    """

    trace = "One end too warm, the other too cold, from the first minute on, at rest and while driving."
    difference = Param(2.0, "K", lo=-10.0, hi=10.0, null=0.0, source="motor and spindle side of a machine, a few K")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        screw, places = rig.the_screw(), [c.at_mm for c in rig.channels.values() if c.at_mm is not None]
        lo, hi = min(places, default=screw.from_mm), max(places, default=screw.to_mm)
        if lo == hi:
            raise SetupError("needs two thermometers along the screw")
        yield Shift("ambient", p.difference, over=(screw.x_mm - (lo + hi) / 2) / (hi - lo))
