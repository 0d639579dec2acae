"""All hypotheses on one ground: effects, own parameters, wrong inputs, pairs of them; the best are fitted in full."""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations

import numpy as np

from estimator.batch.trials import Trials
from estimator.effect import Effect
from estimator.hypotheses.candidates import Candidate, candidates
from estimator.hypotheses.criterion import GOOD, PROMISE, clearly, material, most, proven, worth
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.hypothesis import Hypothesis, refined
from estimator.hypotheses.panel import Explanation, Panel
from estimator.hypotheses.screening import Screened, screening
from estimator.hypotheses.slopes import Column
from estimator.missing_effect.wrong_always import inputs_in, is_input, too_small, wrong_inputs

REFINED = 3  # effects, own parameters, pairs that are fitted in full on each ground; wrong inputs before the last too


class Side:
    """One ground and what is found on it.

    ground  around which they are screened;  plain: the model alone;  tried: how many there are
    """

    def __init__(self, plain: Hypothesis, trials: Trials, effects: Sequence[type[Effect]]) -> None:
        self.trials, self.plain = trials, plain
        self.ground = replace(plain.ground, model=plain.model) if plain.refit else plain.ground
        self.wide, listed = candidates(self.ground.model, trials[0].rig, [*effects, *wrong_inputs(trials)])
        self.screened = screening(self.ground, self.wide, listed, self.trials)
        self.tried = len(listed) + len(self.screened.own)

    @property
    def doubles(self) -> set[str]:
        """Effects that are a parameter of the model under another name."""
        return {one.candidate.name for one in self.screened.best() if one.doubles}

    @property
    def least(self) -> float:
        """As `cost`, of the best that the screen promises and more: below what will be reached."""
        screened = [*(one.judged for one in self.screened.found), *self.screened.own.values()]
        best = min([self.plain.judged.misfit, *(judged.misfit for judged in screened)])
        return self._cost(best / PROMISE)

    @property
    def best(self) -> Explanation:
        """What leaves least."""
        return self.pair.judged if self.pair else self.single

    @property
    def here(self) -> Ground:
        """Around the model with what explains most, all that moves for it moving."""
        best = self.pair or (self.missing[0] if self.missing else self.plain)
        return replace(best.ground, model=best.model, paths=best.paths)

    @cached_property
    def loosest(self) -> Hypothesis:
        """The same, with no own parameter known better than tables know it, and none held."""
        return refined(self.here.freed(*self.screened.own), self.trials, [])

    @property
    def single(self) -> Explanation:
        """What leaves least of the model alone and with one effect more, of a size that can be."""
        sound = (h for h in (*self.fitted, *self.own) if not h.at_bound())
        return min((h.judged for h in (self.plain, *sound)), key=lambda judged: judged.misfit)

    @property
    def cost(self) -> float:
        """Nats against this ground: what its best leaves, and what had to be told of the model's parameters for it."""
        return self._cost(self.best.misfit)

    def _cost(self, misfit: float) -> float:
        return replace(self.plain, judged=replace(self.plain.judged, misfit=misfit)).cost

    @cached_property
    def missing(self) -> list[Hypothesis]:
        """Effects, absent or of the model, that explain clearly more than the model alone; the best first."""
        return [h for h in self._likely if proven(self.plain.judged, h.judged, self.tried)]

    @property
    def _likely(self) -> list[Hypothesis]:
        """Effects that are worth having, the best first; a wrong input where, set right, recordings are well."""
        plain, both = self.plain.judged, sorted([*self.fitted, *self.own], key=lambda h: h.misfit)
        return [h for h in both if worth(h, plain) and self._sets_right(h)]

    def _sets_right(self, h: Hypothesis) -> bool:
        """Whether a wrong input, where one is in it, is most of what is wrong."""
        return most(self.plain.judged, h.judged) or not inputs_in(h.names)

    @cached_property
    def told(self) -> list[Hypothesis]:
        """What is missing, and where the best of it is an effect what is of the same likelihood, proven alone or not.

        That something is there is proven by the best: which it is has to be asked of all. But no effect is named beside
        a parameter of another value that is not proven.
        """
        found = self.missing
        if not found or found[0].freed:
            return found
        rest = [h for h in self._likely if h not in found]
        return [*found, *(h for h in rest if not clearly(h.judged, found[0].judged, 1))]

    @cached_property
    def pair(self) -> Hypothesis | None:
        """Two effects, or one and a wrong input, that explain clearly more than the best alone.

        Where none alone is proven, more than the model does: then it is the best of all pairs.
        """
        both = self._pairs([one.candidate for one in self._few(2 * REFINED)])
        best, tried = (self.single, self.tried) if self.missing else (self.plain.judged, math.comb(self.tried, 2))
        fitted = [refined(self.ground, self.trials, two) for two in self._to_fit(both, best, tried)]
        found = [h for h in fitted if material(h, best, tried) and self._sets_right(h) and not too_small(h)]
        return min(found, key=lambda h: h.misfit, default=None)

    def _to_fit(
        self, both: Sequence[tuple[list[Candidate], Explanation]], best: Explanation, tried: int
    ) -> list[list[Candidate]]:
        """Pairs, best first, that are fitted in full: those that the screen promises, with what is best of all.

        Of what stores heat slopes tell little: while much is left, such pairs are fitted whatever the screen says.
        """
        promising = bool(both) and clearly(best, both[0][1], tried)
        sound = [two for two, _ in both if not any(map(is_input, two))]
        few = sound[:REFINED] if promising else []
        if best.misfit > GOOD:
            few += [two for two in sound[len(few) :] if any(one.body for one in two)][:REFINED]
        return [*few, both[0][0]] if promising and both[0][0] not in few else few

    def _few(self, count: int) -> list[Screened]:
        """The best effects of the screen, so many, and each wrong input that promises more than the last of them."""
        ranked = self.screened.best()
        effects = [one.judged.misfit for one in ranked if not is_input(one.candidate)][:count]
        return [one for one in ranked if one.judged.misfit <= max(effects, default=np.inf)]

    def _pairs(self, few: Sequence[Candidate]) -> list[tuple[list[Candidate], Explanation]]:
        """Two of a few effects together, best first, none of them fitted in full."""
        columns, at = [Column(self.wide, path) for path in self.ground.paths], list[range]()
        beside = range(len(columns))
        for each in few:
            at.append(range(len(columns), len(columns) + len(each.paths)))
            columns += [Column(each.place(self.wide), path) for path in each.paths]
        known = self.ground.belief(self.wide, [column.path for column in columns])
        panel = Panel.of(self.trials, self.wide, columns, known, self.ground.model)
        two = [pair for pair in combinations(range(len(few)), 2) if not all(is_input(few[i]) for i in pair)]
        both = [([few[i], few[j]], panel.judge([*beside, *at[i], *at[j]])) for i, j in two]
        return sorted(both, key=lambda one: one[1].misfit)

    @cached_property
    def fitted(self) -> list[Hypothesis]:
        """The best effects of the screen, fitted in full; what stores heat always, and from its usual size too."""
        tried, few = list[Hypothesis](), self._few(REFINED)
        for one in self.screened.best():
            if one in few or one.candidate.body:
                tried.append(refined(self.ground, self.trials, [one.candidate], one.first))
            if one.candidate.body:
                tried.append(refined(self.ground, self.trials, [one.candidate]))
        return each_once(sorted((h for h in tried if not too_small(h)), key=lambda h: h.misfit))

    @cached_property
    def own(self) -> list[Hypothesis]:
        """The model with one of its own parameters of another value, the best few of them fitted in full."""
        found = []
        for path in sorted(self.screened.own, key=lambda path: self.screened.own[path].misfit)[:REFINED]:
            h = refined(self.ground.freed(path), self.trials, [])
            found.append(replace(h, names=(path.partition(".")[0],), freed=path))
        return each_once(sorted(found, key=lambda h: h.misfit))


def each_once(hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The best of each name, of hypotheses that stand best first."""
    best: dict[tuple[str, ...], Hypothesis] = {}
    for each in hypotheses:
        best.setdefault(each.names, each)
    return list(best.values())
