"""What no catalogue has, written down as an effect: a place, a law, a size, fitted in full.

The stand-in that explains most (`unexplained`) has a width, and an exponent or a time, that it was tried at. Here these
are free: its law, and the best of other forms of laws there, becomes a class of its own (`effect_text`) and is
fitted with all its numbers; the one that leaves least on recordings left out is it. The class that the fit uses is made
from the text that a user gets.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

from estimator.batch.trials import Trials
from estimator.effect import Effect
from estimator.hypotheses.candidates import Candidate
from estimator.hypotheses.criterion import CHANCE, PROMISE, alike, worth
from estimator.hypotheses.hypothesis import Hypothesis, refined
from estimator.hypotheses.panel import Explanation
from estimator.model import Value
from estimator.rig import Rig
from estimator.unknown.effect_text import effect_text
from estimator.unknown.law import law_of
from estimator.unknown.stand_ins import Unknown, unknown_of
from estimator.unknown.unexplained import Unexplained
from estimator.unknown.written import effect_of, name_of, wanted_of

LAWS = 4  # forms that are fitted in full
STRENGTHS = ("power", "g", "shift")  # what a template calls the size of its effect


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

    before  what is left without it;   taken: names that effects have already
    By one recording, of which nothing can be left out, none is composed.
    """
    if len({trial.recording.fingerprint for trial in trials}) < 2:
        return None
    rig, tried = trials[0].rig, []
    for unknown, strength in _laws(found, rig):
        first = dict.fromkeys(STRENGTHS, Value(strength))
        text = effect_text(wanted_of(unknown, name_of(unknown, taken), first), rig)
        h = _fitted(effect_of(text), unknown, found, trials)
        if worth(h, before):
            tried.append((unknown, h))
    if not tried:
        return None
    best, h = min(tried, key=lambda one: one[1].misfit)
    rivals = tuple(one for one, other in tried if other is not h and alike(other.judged, h.judged, len(tried)))
    own = {path.partition(".")[2]: value for path, value in h.own().items()}
    here = replace(best, at_mm=own["at"].value) if "at" in own else best
    wanted = wanted_of(here, type(h.model.effects[h.names[0]]).__name__, own, f"found in {len(trials)} recordings")
    text = effect_text(wanted, rig)
    effect = effect_of(text)
    model = replace(h.model, effects={**h.model.effects, effect.name: effect()})
    return Composed(here, text, effect, replace(h, model=model), before, rivals, found.tried)


def _fitted(effect: type[Effect], unknown: Unknown, found: Unexplained, trials: Trials) -> Hypothesis:
    """The effect fitted in full, from where the stand-in has left the model's own parameters."""
    ground = found.hypothesis.ground
    start = {path: float(found.hypothesis.model[path]) for path in ground.paths}
    seat = Candidate(effect, (), {}, "heat" if unknown.channel is None else "reading", body=False)
    return refined(ground, trials, [seat], start)


def _laws(found: Unexplained, rig: Rig) -> Iterator[tuple[Unknown, float]]:
    """The laws to fit in full, the best of each form, with the size at which a fit may begin.

    Those too that are clearly worse as they were tried: with other numbers in it a form may be the better one.
    """
    best, size = unknown_of(found.candidate, rig), next(iter(found.hypothesis.own().values()))
    listed = [(best, float(size.value))]
    near = [one for one in found.there if one.judged.misfit < PROMISE * found.judged.misfit]
    listed += [(unknown_of(one.candidate, rig), one.first[one.candidate.paths[0]]) for one in near]
    forms: dict[tuple[str, bool], tuple[Unknown, float]] = {}
    for one, strength in listed:
        if one.follower.loss and strength < 0:
            continue  # what conducts the wrong way is no effect
        forms.setdefault((law_of(one.follower).formula, one.follower.loss), (one, strength))
    yield from list(forms.values())[:LAWS]
