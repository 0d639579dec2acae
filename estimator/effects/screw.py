"""The screw itself: it stores heat and conducts it along its axis."""

from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np

from estimator.effect import Effect, Param
from estimator.inputs.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import SCREW, Chain, Store, Term


class Conduction(Effect):
    """The screw stores heat and conducts it along its axis.

    capacity rho c A dT/dt = d/dx (scale k A dT/dx)

    scale     conductivity against the table value of the rig file, 1
    capacity  heat stored against density times heat capacity of the rig file, 1: temperatures tell heat only by it
    noise     heat that no effect describes, W/sqrt(Hz) per sqrt(m)
    """

    trace = "Peaks too sharp or too flat."
    scale = Param(1.0, "1", lo=0.5, hi=2.0, sd=0.04, fixed=True, source="SCM420: 42 - 50 W/(m K)")
    capacity = Param(1.0, "1", lo=0.5, hi=2.0, sd=0.015, fixed=True, source="steel: 7850 kg/m3, 470 J/(kg K), +-2 %")
    noise = Param(1.2, "W/sqrt(Hz m)", lo=0.01, hi=100.0, fixed=True, source="by coverage on simulated runs")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        screw = rig.the_screw()
        capacity = p.capacity * screw.density * screw.heat_capacity * screw.area * screw.length
        yield Store(SCREW, capacity, p.noise * np.sqrt(screw.length))
        yield Chain(SCREW, p.scale * screw.conductivity * screw.area / screw.length)
