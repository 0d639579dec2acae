"""Whether a model fits a rig, asked once before a run; what does not fit is one line that names the effect."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from estimator.errors import SetupError, nearest
from estimator.inputs.inputs import Inputs, nothing
from estimator.inputs.motion import Motion
from estimator.model import Model
from estimator.network.sound import Sound
from estimator.rig import Rig
from estimator.terms import ELONGATION, START, Chain, Heat, Lag, Link, Read, Shift, Store, Term


def checked_terms(model: Model, u: Inputs, rig: Rig, sound: Sound | None = None) -> list[Term]:
    """All terms of a model at the inputs `u`, of any value; a model that does not fit the rig is an EffectError."""
    sound = sound or Sound(model, rig)
    by_effect = {name: sound.of(name, u, forced=False) for name in model.effects}
    stored = {term.node for terms in by_effect.values() for term in terms if isinstance(term, Store)}
    ones = {name: np.ones_like(column) for name, column in u.values.items()}
    other = replace(u, values=ones, rises=ones, motion=Motion(*np.ones((4, len(u), 1))))
    for name, terms in by_effect.items():
        for word, known, problem in _words(terms, stored, rig):
            if word not in known:
                raise model.error(name, f"{problem}; {nearest(word, known)}")
        if not _alike(terms, sound.of(name, other, forced=False)):
            may = "parameters, u.omega, u.unevenness, u.idle and u.coverage"
            raise model.error(name, f"the g of a Link depends on an input; it may depend on {may} only")
    for name, problem in _together(by_effect, stored):
        raise model.error(name, problem)
    return [term for terms in by_effect.values() for term in terms]


def asks_for(model: Model, rig: Rig, name: str) -> bool:
    """Whether an effect makes its heat or readings of this input: not one that is a boundary only."""
    u = nothing(rig)
    without = replace(u, values={other: column for other, column in u.values.items() if other != name})
    try:
        list(model.terms(without, rig))
    except SetupError:
        return True
    return False


def _together(by_effect: Mapping[str, Sequence[Term]], stored: set[str]) -> Iterator[tuple[str, str]]:
    """What only all terms together tell: which effect, and what is wrong."""
    owner: dict[str, str] = {}
    scatter: dict[str, float] = {}
    for name, terms in by_effect.items():
        for term in terms:
            if isinstance(term, Store):
                if term.node in owner:
                    yield name, f"node '{term.node}' is stored twice, by {owner[term.node]} too; one declares its Store"
                owner[term.node] = name
            elif isinstance(term, Link) and not {term.a, term.b} & stored:
                yield name, f"a Link is between '{term.a}' and '{term.b}', neither of which any effect stores"
            elif isinstance(term, Read):
                scatter[term.channel] = scatter.get(term.channel, 0.0) + abs(term.sd)
    for name, terms in by_effect.items():
        for term in terms:
            if isinstance(term, Read) and not scatter[term.channel]:
                yield name, f"reads '{term.channel}' without scatter; say its sd in one Read of it"


def _words(terms: Iterable[Term], stored: set[str], rig: Rig) -> Iterator[tuple[str, set[str], str]]:
    """What each term names, what there is, and the problem if it is not among it."""
    file, unstored = rig.folder / "rig.toml", "which no effect of the model stores"
    for term in terms:
        if isinstance(term, Link):
            for end in (term.a, term.b):
                yield (
                    end,
                    stored | {*rig.inputs, START},
                    f"a Link ends at '{end}', {unstored} and {file} has not in [inputs]",
                )
        elif isinstance(term, Shift):
            yield term.input, {*rig.inputs}, f"a Shift is of '{term.input}', which {file} has not in [inputs]"
        elif isinstance(term, Chain) or (isinstance(term, Heat) and not term.spare):
            yield term.node, stored, f"a {type(term).__name__} is in '{term.node}', {unstored}"
        elif isinstance(term, (Read, Lag)):
            yield term.channel, {*rig.channels}, f"reads '{term.channel}', which {file} has not in [channels]"
            for node in term.weights if isinstance(term, Read) else ():
                yield node, stored | {ELONGATION}, f"channel '{term.channel}' reads '{node}', {unstored}"


def _alike(terms: Sequence[Term], others: Sequence[Term]) -> bool:
    """Whether the terms conduct and store the same."""
    pairs = zip(terms, others, strict=True)
    return all(
        np.array_equal(getattr(a, key), getattr(b, key))
        for a, b in pairs
        for key in ("g", "capacity", "over")
        if hasattr(a, key) and not isinstance(a, (Heat, Shift))
    )
