"""The table that stands elsewhere than the position says, as an effect that sets the position right."""

from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace

from estimator.effect import Effect, Param
from estimator.inputs.inputs import Inputs
from estimator.inputs.moved import moved
from estimator.rig import Rig
from estimator.terms import Term


class Elsewhere(Effect):
    """The position of the table is told with another zero than the rig file means.

    position = told - shift
    """

    shift = Param(10.0, "mm", lo=-1000.0, hi=1000.0, null=0.0, source="by search")

    def inputs(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Inputs:
        return replace(u, coverage=moved(u.coverage, rig, shift_mm=-p.shift)) if p.shift else u

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        yield from ()  # it moves what others do


SHIFT = f"{Elsewhere.name}.shift"
