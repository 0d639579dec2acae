"""What may be missing from a model: every effect that fits the rig and is not in it yet, and where it may sit."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from estimator.effect import Effect
from estimator.errors import SetupError
from estimator.inputs.follower import followers
from estimator.inputs.inputs import no_inputs, nothing
from estimator.model import Model
from estimator.network.check import checked_terms
from estimator.rig import Rig
from estimator.terms import OF_READINGS, Store, Term

APART_MM = 30.0  # places tried along the screw are about so far apart


@dataclass(frozen=True)
class Candidate:
    """One effect, sitting where `at` says.

    paths  parameters "effect.param" that are null while the effect is absent: what a score test moves
    at     values of the parameters that say where it sits
    kind   "heat" or "reading": whether it moves temperatures, or only what sensors make of them
    body   whether it brings a body that stores heat, of which little shows at its null
    """

    effect: type[Effect]
    paths: tuple[str, ...]
    at: Mapping[str, float]
    kind: str
    body: bool

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.effect.name

    def place(self, model: Model) -> Model:
        """A model that has the effect, with the effect where this one sits."""
        return model.with_values(self.at)


def candidates(model: Model, rig: Rig, effects: Iterable[type[Effect]]) -> tuple[Model, list[Candidate]]:
    """The model with every effect that fits, each at its null, and where each may sit.

    Effects that the rig cannot have (no nut, no such input), that the model has, or that have no null, are left out.
    """
    found: list[Candidate] = []
    for effect in effects:
        if effect.name in model.effects or not _nulls(effect) or unfit(model, rig, effect):
            continue
        model = at_null(model + effect, effect)
        found += _seats(model, effect, rig)
    return model, found


def unfit(model: Model, rig: Rig, effect: type[Effect]) -> str:
    """Why a model of this rig cannot have the effect, in one line; empty where it can."""
    try:
        checked_terms(at_null(model + effect, effect), nothing(rig), rig)
    except SetupError as error:
        return str(error)
    except Exception as error:  # an effect of a user's own, written for another rig
        return f"{effect.name}: {type(error).__name__}: {error}"
    return ""


def at_null(model: Model, effect: type[Effect]) -> Model:
    """The model with one of its effects made invisible."""
    return model.with_values(_nulls(effect))


def kind_of(model: Model, name: str, rig: Rig) -> str:
    """Whether an effect of a model moves temperatures, or only readings."""
    terms = _at_ones(model, name, rig)
    return "reading" if terms and all(isinstance(term, OF_READINGS) for term in terms) else "heat"


def _at_ones(model: Model, name: str, rig: Rig) -> list[Term]:
    """Terms of one effect while everything turns and is covered."""
    ones = no_inputs(rig, np.ones((1, 1)), np.ones((1, rig.screw.cells if rig.screw else 0)))
    return list(model.terms_of(name, ones, rig))


def _nulls(effect: type[Effect]) -> dict[str, float]:
    return {f"{effect.name}.{key}": p.null for key, p in effect.params.items() if p.null is not None}


def _seats(model: Model, effect: type[Effect], rig: Rig) -> list[Candidate]:
    terms = _at_ones(model, effect.name, rig)
    body = any(isinstance(term, Store) for term in terms)
    found = [Candidate(effect, tuple(_nulls(effect)), {}, kind_of(model, effect.name, rig), body)]
    for key, param in effect.params.items():
        if param.over:
            path, values = f"{effect.name}.{key}", SEATS[param.over](rig)
            found = [replace(c, at={**c.at, path: float(v)}) for c in found for v in values]
    return found


def places(rig: Rig) -> Sequence[float]:
    """Places along the screw where something may sit, mm: evenly from the first thermometer to the last."""
    at = [c.at_mm for c in rig.channels.values() if c.at_mm is not None]
    if rig.screw is None or not at:
        return ()
    return [float(x) for x in np.linspace(min(at), max(at), max(2, round((max(at) - min(at)) / APART_MM) + 1))]


SEATS: Mapping[str, Callable[[Rig], Sequence[float]]] = {
    "place": places,
    "channel": lambda rig: range(1, len(rig.thermometers) + 1),
    "reading": lambda rig: range(len(rig.names) + 1),
    "spread": lambda rig: range((rig.screw is not None) + (rig.nut is not None)),
    "node": lambda rig: range(len(rig.bodies)),
    "follower": lambda rig: range(len(followers(rig))),
}
