"""Heat that some effects of a model bring, zone by zone, to be laid beside what a model lacks (`missing_heat`).

q(x, t) = sum of their Heat terms + g over (T_b - T) of their Links, T of the model alone
"""

from collections.abc import Iterable, Sequence

import numpy as np

from estimator.batch.trial import Posed, Trial
from estimator.inputs.inputs import Inputs
from estimator.missing_heat.zones import Zone
from estimator.network.layout import Layout
from estimator.record import Array
from estimator.terms import SCREW, Heat, Link, Term


def brought(names: Iterable[str], trial: Trial, posed: Posed, places: Sequence[Zone]) -> Array:
    """What these effects bring into each zone in each tick of a trial, (T, zones): W/m on the screw, W in bodies."""
    model, place = posed.forcing.model, posed.forcing.place
    u = model.inputs(trial.drive.inputs, trial.rig)
    terms = [term for name in names for term in model.terms_of(name, u, trial.rig)]
    into = {node: _into(node, terms, u, posed.run.z, place)[1:] for node in {zone.node or SCREW for zone in places}}
    return np.column_stack([_in_zone(zone, into[zone.node or SCREW], trial) for zone in places])


def _into(node: str, terms: Iterable[Term], u: Inputs, z: Array, place: Layout) -> Array:
    """W into each cell of a node, (ticks, cells); z (ticks, n) are the states."""
    heat = np.zeros((len(u), len(place.rows(node))))
    for term in terms:
        if isinstance(term, Heat) and term.node == node:
            heat += np.multiply(term.q, term.over)
        elif isinstance(term, Link) and node in (term.a, term.b):
            other = term.b if term.a == node else term.a
            beyond = z @ place.rows(other).T if other in place.nodes else u[other]
            heat += np.multiply(term.g, term.over) * (beyond - z @ place.rows(node).T)
    return heat


def _in_zone(zone: Zone, heat: Array, trial: Trial) -> Array:
    """Of the heat (T, cells) into a node what a zone has of it, (T,)."""
    if zone.from_mm is None or zone.to_mm is None:
        return heat[:, 0]
    return np.asarray(heat @ trial.rig.the_screw().overlap(zone.from_mm, zone.to_mm) / zone.length_m)
