"""The law of a heat whose shape was drawn, as an effect: what a model that knows it has."""

from collections.abc import Callable, Iterator
from types import SimpleNamespace

import numpy as np

from drivers.virtual_rig.machine.drawn import Drawn
from drivers.virtual_rig.machine.geometry import OMEGA_20
from estimator.effect import Effect, Param
from estimator.inputs.inputs import Inputs
from estimator.record import Array
from estimator.rig import Rig
from estimator.terms import SCREW, Heat, Term

Law = Callable[[Drawn, Inputs, Rig], Array]


def _fading(one: Drawn, u: Inputs) -> Array:
    return np.asarray(np.exp(-u.motion.since_s / one.seconds))


def _rested(u: Inputs) -> Array:
    return np.asarray((1.0 - u.motion.turning) * u.motion.moved)


LAWS: dict[str, Law] = {
    "power": lambda one, u, rig: u.speed_law(rig.the_screw(), one.exponent),
    "gate": lambda one, u, rig: (u.omega > one.share * OMEGA_20).astype(float),
    "surge": lambda one, u, rig: u.speed_law(rig.the_screw(), one.exponent) * _fading(one, u),
    "blast": lambda one, u, rig: _rested(u) * _fading(one, u),
    "soak": lambda one, u, rig: _rested(u) * (1.0 - _fading(one, u)),
    "two": lambda one, u, rig: u.motion.turning + one.share * _rested(u),
}


def true_law(one: Drawn) -> type[Effect]:
    """An effect of the drawn place, length and law, of which only the power is fitted."""

    class DrawnHeat(Effect):
        """Heat of a shape that was drawn."""

        power = Param(one.watts, "W", lo=-200.0, hi=200.0, null=0.0)

        def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
            over = rig.the_screw().overlap(one.place_mm - one.width_mm / 2.0, one.place_mm + one.width_mm / 2.0)
            yield Heat(SCREW, p.power * LAWS[one.kind](one, u, rig), over=over / over.sum())

    return DrawnHeat
