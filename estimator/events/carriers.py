"""What may begin: heat at a place, or a part of the model that grows or shrinks."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from estimator.batch.trial import Posed, Trial
from estimator.events.event import HOT, PART
from estimator.inputs.inputs import nothing
from estimator.missing_heat.zones import Zone, heat_of, zones
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.sensitivity import pushed
from estimator.sensitivity.tangent import tangent
from estimator.terms import Chain, Link, Store


@dataclass(frozen=True)
class Carrier:
    """Something that heats, at size 1: 1 W in a zone, or once more all that an effect of the model does.

    push   (T, n) K that each tick adds to the states;   heat_W  (T,) W in all
    loses  whether all that it does is to exchange heat with what is measured: the air, a base
    """

    kind: str
    name: str
    zone: Zone | None
    push: Array
    heat_W: Array
    loses: bool = False


def carriers(trial: Trial, posed: Posed, model: Model) -> list[Carrier]:
    """All of them."""
    places = zones(trial.rig, posed.forcing.place)
    return [*(_at(zone, trial, posed) for zone in places), *_parts(trial, posed, model)]


def _at(zone: Zone, trial: Trial, posed: Posed) -> Carrier:
    heat = heat_of(zone, trial.rig, posed.forcing.place) / zone.length_m
    regime = posed.system.regime
    push = np.empty_like(posed.heat)
    for r in np.unique(regime):
        push[regime == r] = posed.forcing.transition(r).J @ heat
    name = zone.node or f"{zone.middle_mm:.0f} mm"
    return Carrier(HOT, name, zone, push, np.ones(len(regime)))


def _parts(trial: Trial, posed: Posed, model: Model) -> Iterator[Carrier]:
    """Effects with all of their parameters that are W, or W per something: what heat is in proportion to.

    Not those that bring a body: what it stores and passes on is as it was built.
    """
    u = nothing(trial.rig)
    for name, effect in model.effects.items():
        terms = list(model.terms_of(name, u, trial.rig))
        if any(isinstance(term, (Store, Chain)) for term in terms):
            continue
        paths = [f"{name}.{key}" for key, param in effect.params.items() if param.unit.startswith("W")]
        push = np.zeros_like(posed.heat)
        for path in paths:
            moved = tangent(trial, posed, model, path)
            if moved.moves_states and np.ndim(model[path]) == 0:
                push += model[path] * pushed(posed, [moved])[0]
        if push.any():
            loses = all(isinstance(term, Link) and term.b in trial.rig.inputs for term in terms)
            yield Carrier(PART, name, None, push, _watts(push, posed), loses)


def _watts(push: Array, posed: Posed) -> Array:
    """Heat that does this to the states, W in all, (T,)."""
    regime = posed.system.regime
    heat = np.zeros(len(push))
    for r in np.unique(regime):
        heat[regime == r] = np.linalg.solve(posed.forcing.transition(r).J, push[regime == r].T).sum(axis=0)
    return heat
