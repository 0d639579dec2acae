"""A bench for one effect: the model of a rig that it is put into, and inputs under which everything happens."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from estimator.battery import exercise
from estimator.effect import Effect
from estimator.errors import SetupError
from estimator.inputs.inputs import Inputs, nothing
from estimator.model import Model
from estimator.network import assemble
from estimator.network.forcing import Drive, Forcing
from estimator.network.layout import Layout
from estimator.record import Array
from estimator.rig import Rig
from estimator.terms import Spot, Term


@dataclass(frozen=True)
class Bench:
    """An effect, the model that it is put into (which lacks it), and the rig."""

    effect: type[Effect]
    base: Model
    rig: Rig

    @cached_property
    def model(self) -> Model:
        """The model with the effect, at its defaults."""
        return self.base + self.effect

    @cached_property
    def u(self) -> Inputs:
        """Three ticks that differ in everything."""
        return exercise.instants(self.rig)

    @cached_property
    def _driven(self) -> tuple[Forcing, Drive]:
        """A run in which everything happens, read once for all models."""
        forcing = exercise.forced(self.model, self.rig)
        return forcing, forcing.read(exercise.run(self.rig))

    @cached_property
    def nulls(self) -> dict[str, float]:
        """The null of each parameter that has one, by key."""
        return {key: param.null for key, param in self.effect.params.items() if param.null is not None}

    def at(self, **values: Any) -> Model:
        """The model with other values of the effect's parameters."""
        return self.model.with_values({f"{self.effect.name}.{key}": value for key, value in values.items()})

    def terms(self, **values: Any) -> list[Term]:
        """What the effect yields with these values in the three ticks."""
        return list(self.at(**values).terms_of(self.effect.name, self.u, self.rig))

    def reads(self, model: Model) -> Array:
        """What the channels read by a model alone, (K, m)."""
        forcing, drive = self._driven
        return exercise.alone(forcing.with_model(model), drive)

    @cached_property
    def at_null(self) -> Array:
        """What they read by the model with the effect at its nulls."""
        return self.reads(self.at(**self.nulls))

    def numbers(self, place: Layout, **values: Any) -> dict[str, Array]:
        """Every number that the effect says, and every one that is assembled from the model's terms, by name."""
        u, terms = self.u, list(self.at(**values).terms(self.u, self.rig))
        own = enumerate(self.terms(**values), start=1)
        made = {f"{name} of term {i}": value for i, term in own for name, value in _of_term(term)}
        made |= vars(assemble.network_of(terms, place, len(u))) | vars(assemble.readings(terms, self.rig, place))
        made["heat"] = assemble.heat(terms, place, len(u))
        made["offsets"] = assemble.offsets(terms, self.rig, len(u))
        made["outside"] = assemble.outside(terms, u, place)
        return {name: np.asarray(v, np.result_type(np.asarray(v), float)) for name, v in made.items()}


def _of_term(term: Term) -> Iterator[tuple[str, Any]]:
    """Every number of a term by name."""
    for key, value in vars(term).items():
        if isinstance(value, Mapping):
            yield from ((node, weight.weight if isinstance(weight, Spot) else weight) for node, weight in value.items())
        elif not isinstance(value, (str, bool, type(None))):
            yield key, value


def without(model: Model, name: str, rig: Rig) -> Model:
    """The model without an effect and without those that cannot do without it; as it is where it lacks the effect."""
    if name not in model.effects:
        return model
    less, u = model - name, nothing(rig)
    for other in model.moved_by(name):
        try:
            if other in less.effects:
                less.terms_of(other, u, rig)
        except SetupError:
            less -= other
    return less
