"""Which effect is missing from a model, if it can be told.

Every hypothesis is judged by the open-loop misfit on recordings left out, temperatures and elongation alike:

    the model alone
    one effect more, or two
    one of its own parameters of another value
    one input of one recording set right
    heat at some place, or an offset of a reading, that follows something (`unknown`)

all of them on either ground: what an earlier fit knows of the model's parameters holds, or only tables do (`ground`).
An effect must leave clearly less than the model does without it, and what leaves as little is named beside it as a tie.
Recordings held out are never looked at for this.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations

import numpy as np

from estimator.accuracy.noise_floor import noise_floor
from estimator.batch.trials import Trials, slow_trials_of
from estimator.effect import Effect
from estimator.missing_effect.candidates import Candidate, candidates
from estimator.missing_effect.ground import Ground, as_given, of_tables, seen
from estimator.missing_effect.hypothesis import Hypothesis, refined
from estimator.missing_effect.moments import Column
from estimator.missing_effect.panel import Explanation, Panel
from estimator.missing_effect.screening import Screened, screening
from estimator.missing_effect.stand_ins import UnknownBodyHeat, UnknownHeat, UnknownReading
from estimator.missing_effect.suggestion import GOOD, Suggestion, alike, clearly, material
from estimator.missing_effect.wrong_input import Mislabel, mislabel
from estimator.model import Model
from estimator.sensitivity.objective import GOOD_K, GOOD_UM
from estimator.work import Runs

FAR = 5.0  # times what a good model or the sensors leave, from which on something is missing, explained or not
PROMISE = 4.0  # times less than the screen says may be left of a misfit once an effect is fitted in full
REFINED = 3  # effects, own parameters and pairs that are fitted in full on each ground


def suggest(
    model: Model, runs: Runs, effects: Iterable[type[Effect]], loose: Collection[str] = (), healthy: Runs | None = None
) -> Suggestion:
    """Look for what is missing.

    loose    effects of the model whose parameters were found from these recordings: what is missing has bent them
    healthy  recordings of the same machine in which nothing is missing: the model is fitted to them first, so that the
             question is what has changed since
    """
    if healthy is not None:
        model = refined(of_tables(model), slow_trials_of(model, healthy), []).known()
    return Search(model, runs, list(effects), loose, told=healthy is not None).run()


class Search:
    """One search: the recordings made ready once, and hypotheses tried on them.

    as_given, again  the model without any effect more: as it is, give or take what its fit left open; fitted again
    """

    def __init__(
        self, model: Model, runs: Runs, effects: Sequence[type[Effect]], loose: Collection[str], told: bool
    ) -> None:
        self.model, self.runs, self.effects, self._told = model, runs, effects, told
        runs.progress("reading the misfit", 0.0)
        self.trials = slow_trials_of(model, runs)
        self.as_given = refined(as_given(model, runs, loose), self.trials, [])
        runs.progress("fitting the model again", 0.05)
        self.again = refined(of_tables(model), self.trials, [])

    def run(self) -> Suggestion:
        """All stages, and the verdict."""
        sides = self._sides()
        side = min(sides, key=lambda side: side.cost)
        self.runs.progress("looking for a wrong input", 0.75)
        wrong = self._wrong(side, side.best)
        self.runs.progress("looking for something unknown", 0.85)
        unexplained = self._unexplained(side, [wrong.judged] if wrong else [])
        return self._verdict(sides, side, wrong, unexplained)

    def _plains(self) -> list[Hypothesis]:
        """The model without effects on each ground that may hold.

        Parameters found from these very recordings are bent by what is missing: they cannot hold as they are.
        """
        if self._told:
            return [self.as_given]
        return [self.again] if seen(self.model, self.runs) else [self.as_given, self.again]

    def _sides(self) -> list[Side]:
        """Each ground that may hold; none that falls short whatever is fitted on it."""
        self.runs.progress("screening the catalogue", 0.15)
        sides = sorted((Side(self, plain) for plain in self._plains()), key=lambda side: side.least)
        self.runs.progress("fitting the best effects", 0.4)
        return [side for side in sides if side is sides[0] or side.least < sides[0].cost]

    def _wrong(self, side: Side, best: Explanation) -> Mislabel | None:
        """A wrong input that explains clearly more than the model alone and than any effects."""
        if best.misfit <= GOOD:
            return None
        found = mislabel(side.ground, self.runs, self.trials)
        if found is None or not clearly(side.plain.judged, found.judged, side.tried):
            return None
        return found if clearly(best, found.judged, 1) else None

    def _unexplained(self, side: Side, also: Sequence[Explanation]) -> Screened | None:
        """What explains clearly more than any one effect or a wrong input, and is in no catalogue.

        Two effects may compose it: heat at a place while driving, and less there always, is heat at rest. Where the
        model is far off all the same, something is missing: the question is not whether, but what it is like.
        """
        if side.best.misfit <= GOOD and not side.pair:
            return None
        wide, unknown = candidates(side.ground.model, self.runs.rig, [UnknownHeat, UnknownBodyHeat, UnknownReading])
        screened = screening(side.ground, wide, unknown, self.trials).best()[:1]
        if not screened:
            return None
        found = _settled(side.ground, self.trials, screened[0])
        if side.pair and clearly(found.judged, side.pair.judged, side.tried):
            return None
        best = min([side.single, *also], key=lambda judged: judged.misfit)
        tried = 1 if self._far(best) else len(unknown)
        return found if clearly(best, found.judged, tried) else None

    def _verdict(
        self, sides: Sequence[Side], side: Side, wrong: Mislabel | None, unexplained: Screened | None
    ) -> Suggestion:
        found = side.missing
        wrong = None if unexplained is not None else wrong  # it leaves clearly more
        far = self._far(wrong.judged if wrong else side.plain.judged)
        named = list(
            dict.fromkeys(h.names[0] for h in found if h is found[0] or alike(h.judged, found[0].judged, side.tried))
        )
        changed, pair = "", side.pair
        if wrong is not None:
            verdict, found = "input_error", []
        elif unexplained is not None:
            verdict, found = "nothing_in_catalogue", []
        elif found and all(name in self.model.effects for name in named):
            verdict, changed = "nothing_missing", found[0].freed
        elif pair and not found:
            verdict, found = "effects", [pair]
        elif found:
            verdict = "tie" if len(named) > 1 else "effect"
        else:
            verdict = "nothing_in_catalogue" if far else "nothing_missing"
        rest = sorted((h for one in sides for h in one.fitted if not _named(h, found)), key=lambda h: h.misfit)
        return Suggestion(
            verdict, (*found, *_each_once(rest)), tuple(named) if verdict == "tie" else (), self.as_given, self.again,
            side.plain, self.trials.uses, changed, tuple(pair.names) if pair else (), wrong, unexplained, far,
        )  # fmt: skip

    def _far(self, judged: Explanation) -> bool:
        """Whether a model is so far off that something must be missing."""
        floor = noise_floor(self.model, self.trials[0])
        heat, length = np.fmax(GOOD_K, floor.temperature_K), np.fmax(GOOD_UM, floor.elongation_um)
        return bool(judged.error.temperature_K > FAR * heat or judged.read_um > FAR * length)


class Side:
    """All hypotheses on one ground.

    ground  around which they are screened;  plain: the model alone;  tried: how many there are
    """

    def __init__(self, search: Search, plain: Hypothesis) -> None:
        self.trials, self.plain = search.trials, plain
        self.ground = replace(plain.ground, model=plain.model) if plain.refit else plain.ground
        self.wide, listed = candidates(self.ground.model, search.runs.rig, search.effects)
        self.screened = screening(self.ground, self.wide, listed, self.trials)
        self.tried = len(listed) + len(self.screened.own)

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
    def single(self) -> Explanation:
        """What leaves least of the model alone and with one effect more, of a size that can be."""
        sound = (h for h in (*self.fitted, *self.own) if not h.at_bound())
        return min((h.judged for h in (self.plain, *sound)), key=lambda judged: judged.misfit)

    @property
    def cost(self) -> float:
        """Nats against this ground: what its best leaves, and what had to be told of the model's parameters for it.

        n / 2 ln(misfit) + ln det(1 + S P^-1) / 2: minus the logarithm of the evidence (Laplace)
        """
        return self._cost(self.best.misfit)

    def _cost(self, misfit: float) -> float:
        return 0.5 * self.plain.judged.weight * float(np.log(misfit)) + self.plain.told

    @cached_property
    def missing(self) -> list[Hypothesis]:
        """Effects, absent or of the model, that explain clearly more than the model alone; the best first."""
        both = sorted([*self.fitted, *self.own], key=lambda h: h.misfit)
        return [h for h in both if material(h, self.plain.judged, self.tried)]

    @cached_property
    def pair(self) -> Hypothesis | None:
        """Two effects that explain clearly more than the best alone."""
        names = [one.candidate for one in self.screened.best()[: 2 * REFINED]]
        both = self._pairs(names)
        best = self.single
        if not both or not clearly(best, both[0][1], self.tried):
            return None
        fitted = [refined(self.ground, self.trials, two) for two, _ in both[:REFINED]]
        found = [h for h in fitted if material(h, best, self.tried)]
        return min(found, key=lambda h: h.misfit, default=None)

    def _pairs(self, few: Sequence[Candidate]) -> list[tuple[list[Candidate], Explanation]]:
        """Two of a few effects together, best first, none of them fitted in full."""
        columns, at = [Column(self.wide, path) for path in self.ground.paths], list[range]()
        beside = range(len(columns))
        for each in few:
            at.append(range(len(columns), len(columns) + len(each.paths)))
            columns += [Column(each.place(self.wide), path) for path in each.paths]
        known = self.ground.belief(self.wide, [column.path for column in columns])
        panel = Panel.of(self.trials, self.wide, columns, known)
        both = [([few[i], few[j]], panel.judge([*beside, *at[i], *at[j]])) for i, j in combinations(range(len(few)), 2)]
        return sorted(both, key=lambda one: one[1].misfit)

    @cached_property
    def fitted(self) -> list[Hypothesis]:
        """The best effects of the screen, fitted in full; what stores heat always, and from its usual size too."""
        tried = list[Hypothesis]()
        for rank, one in enumerate(self.screened.best()):
            if rank < REFINED or one.candidate.body:
                tried.append(refined(self.ground, self.trials, [one.candidate], one.first))
            if one.candidate.body:
                tried.append(refined(self.ground, self.trials, [one.candidate]))
        return _each_once(sorted(tried, key=lambda h: h.misfit))

    @cached_property
    def own(self) -> list[Hypothesis]:
        """The model with one of its own parameters of another value, the best few of them fitted in full."""
        found = []
        for path in sorted(self.screened.own, key=lambda path: self.screened.own[path].misfit)[:REFINED]:
            h = refined(self.ground.freed(path), self.trials, [])
            found.append(replace(h, names=(path.partition(".")[0],), freed=path))
        return _each_once(sorted(found, key=lambda h: h.misfit))


def _settled(ground: Ground, trials: Trials, one: Screened) -> Screened:
    """A stand-in fitted in full: at the place that it moves to."""
    h = refined(ground, trials, [one.candidate], one.first)
    at = {path: float(h.model[path]) for path in one.candidate.at}
    return Screened(replace(one.candidate, at=at), h.judged, one.first)


def _named(h: Hypothesis, found: Sequence[Hypothesis]) -> bool:
    return any(h.names == each.names for each in found)


def _each_once(hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The best of each name, of hypotheses that stand best first."""
    best: dict[tuple[str, ...], Hypothesis] = {}
    for each in hypotheses:
        best.setdefault(each.names, each)
    return list(best.values())
