"""What no catalogue has, written down as an effect: a place, a law, a size, fitted in full.

The stand-in that explains most (`unexplained`) has a width and an exponent or time that it was tried at. Here these are
free: its law, and each other law that explains as much there, becomes a class of its own (`effect_text`), is fitted with
all its numbers, and the one that leaves least on recordings left out is it. The class that the fit uses is made from the
text that a user gets.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any

import numpy as np

from estimator.batch.trials import Trials
from estimator.effect import Effect
from estimator.hypotheses.candidates import Candidate
from estimator.hypotheses.criterion import CHANCE, alike, worth
from estimator.hypotheses.hypothesis import Hypothesis, refined
from estimator.hypotheses.panel import Explanation
from estimator.model import Value
from estimator.rig import Rig
from estimator.unknown.effect_text import ALL, VOCABULARY, Wanted, effect_text
from estimator.unknown.law import law_of
from estimator.unknown.stand_ins import Unknown, unknown_of
from estimator.unknown.unexplained import Unexplained

LAWS = 4  # that are fitted in full
STRENGTHS = ("power", "g", "shift")


@dataclass(frozen=True)
class Composed:
    """An effect that no catalogue has, fitted in full.

    unknown     where it acts, and what it follows
    text        the class as Python;   effect: that class;   hypothesis: the model with it
    before      what is left without it
    rivals      what it may follow as well, by these recordings
    tried       from how many candidates it was chosen
    """

    unknown: Unknown
    text: str
    effect: type[Effect]
    hypothesis: Hypothesis
    before: Explanation
    rivals: tuple[Unknown, ...]
    tried: int

    @property
    def by_chance(self) -> float:
        """The share of the misfit that the best of so many takes off by chance in one search of twenty."""
        return 1.0 - float((self.tried / CHANCE) ** (-2.0 / self.before.weight))


def composed(found: Unexplained, before: Explanation, trials: Trials, taken: Collection[str]) -> Composed | None:
    """The effect that something unknown is; None where none with free numbers is worth having.

    before  what is left without it
    taken   names that effects have already
    """
    if len(trials) < 2:
        return None
    rig, ground = trials[0].rig, found.hypothesis.ground
    start = {path: float(found.hypothesis.model[path]) for path in ground.paths}
    tried = []
    for unknown, first in _laws(found, rig):
        wanted = _wanted(unknown, rig, taken, first)
        effect = effect_of(effect_text(wanted, rig))
        seat = Candidate(effect, (), {}, "reading" if unknown.channel is not None else "heat", False)
        h = refined(ground, trials, [seat], start)
        if worth(h, before):
            tried.append((unknown, h))
    if not tried:
        return None
    best, h = min(tried, key=lambda one: one[1].misfit)
    rivals = tuple(one for one, other in tried if other is not h and alike(other.judged, h.judged, len(tried)))
    return _written(best, h, before, rivals, found.tried, rig, trials)


def _written(
    unknown: Unknown, h: Hypothesis, before: Explanation, rivals: tuple[Unknown, ...], tried: int, rig: Rig,
    trials: Trials,
) -> Composed:  # fmt: skip
    """The same with the values that were found as the class's own."""
    name, old = h.names[0], h.model.effects[h.names[0]]
    values = {path.partition(".")[2]: value for path, value in h.own().items()}
    source = f"found in {len(trials)} recordings"
    here = replace(unknown, at_mm=values["at"].value) if "at" in values else unknown
    wanted = Wanted(type(old).__name__, *_sits(here, rig), found=values, source=source)
    text = effect_text(wanted, rig)
    effect = effect_of(text)
    model = replace(h.model, effects={**h.model.effects, name: effect()})
    return Composed(here, text, effect, replace(h, model=model), before, rivals, tried)


def _laws(found: Unexplained, rig: Rig) -> Iterator[tuple[Unknown, dict[str, Value]]]:
    """The laws to fit in full, of each form the best, with the size at which a fit may begin."""
    best = unknown_of(found.candidate, rig)
    size = next(iter(found.hypothesis.own().values()))
    listed = [(best, size.value)]
    for rival in found.rivals:
        one = unknown_of(rival.candidate, rig)
        if replace(one, follower=best.follower) == best:
            listed.append((one, rival.first[rival.candidate.paths[0]]))
    forms: dict[tuple[str, bool], tuple[Unknown, float]] = {}
    for one, strength in listed:
        forms.setdefault((law_of(one.follower).formula, one.follower.loss), (one, strength))
    for one, strength in list(forms.values())[:LAWS]:
        yield one, dict.fromkeys(STRENGTHS, Value(strength))


def _wanted(unknown: Unknown, rig: Rig, taken: Collection[str], first: dict[str, Value]) -> Wanted:
    cls = name = _name(unknown)
    more = iter("BCDEFGHIJ")
    while any(name.lower() == each.replace("_", "") for each in taken):
        name = f"{cls}{next(more)}"
    return Wanted(name, *_sits(unknown, rig), found=first)


def _sits(unknown: Unknown, rig: Rig) -> tuple[Any, ...]:
    """What a new effect follows, where it heats and what it shifts, in the order of Wanted."""
    reading = None if unknown.channel is None else unknown.channel or ALL
    return unknown.follower, unknown.at_mm, unknown.node, unknown.under_nut, reading


def _name(unknown: Unknown) -> str:
    """HeatAt300, HeatInNut, ShiftOfT04."""
    if unknown.channel is not None:
        return f"ShiftOf{(unknown.channel or 'All').title().replace('_', '')}"
    what = "Loss" if unknown.follower.loss else "Heat"
    if unknown.node is not None:
        return f"{what}In{unknown.node.title().replace('_', '')}"
    if unknown.at_mm is None:
        return f"{what}{'UnderNut' if unknown.under_nut else 'AllAlong'}"
    return f"{what}At{unknown.at_mm:.0f}".replace("-", "Minus")


def effect_of(text: str) -> type[Effect]:
    """The class that a text of ours is."""
    names: dict[str, Any] = {"__name__": __name__}
    for name, module in VOCABULARY.items():
        home = import_module(module)
        names[name] = home if module == name or name == "np" else getattr(home, name)
    exec(text, names)  # written by effect_text from numbers and names of the rig
    (found,) = (v for v in names.values() if isinstance(v, type) and issubclass(v, Effect) and v is not Effect)
    return found
