"""Which effect is missing from a model, if it can be told.

Every hypothesis is judged by the open-loop misfit on recordings left out, temperatures and elongation alike:

    the model as it is, or with its own parameters fitted again
    either of these with one effect more, or with two
    either of these with one input of one recording set right
    either of these with heat at some place, or an offset of a reading, that follows something (`unknown`)

An effect must leave clearly less than the model does without it, and a second effect that leaves as little is named
beside it as a tie. Recordings held out are never looked at for this.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from estimator.accuracy.noise_floor import noise_floor
from estimator.batch.trials import slow_trials_of
from estimator.effect import Effect
from estimator.missing_effect.candidates import Candidate, candidates
from estimator.missing_effect.hypothesis import NONE, Hypothesis, refined
from estimator.missing_effect.moments import Column
from estimator.missing_effect.panel import Explanation, Panel
from estimator.missing_effect.screening import Screened, Screening, screening
from estimator.missing_effect.stand_ins import UnknownBodyHeat, UnknownHeat, UnknownReading
from estimator.missing_effect.suggestion import ALIKE, ALONE, GOOD, MATERIAL, Suggestion, alike, material
from estimator.missing_effect.wrong_input import Mislabel, mislabel
from estimator.model import Model
from estimator.sensitivity.objective import GOOD_K, GOOD_UM
from estimator.work import Runs

EXPLAINS = 0.95  # of what a new fit of all parameters gains, that one effect alone may stand for ...
FEW = 4.0  # ... if its misfit is within this of the best: one number instead of many
STRANGE = 0.8  # something unknown leaves at most this share of what the best effects leave
FAR = 5.0  # times what a good model or the sensors leave, from which on something is missing, explained or not
REFINED = 3  # effects of each kind that are fitted in full


def suggest(model: Model, runs: Runs, effects: Iterable[type[Effect]], loose: Collection[str] = ()) -> Suggestion:
    """Look for what is missing.

    loose  effects of the model whose parameters were found from these recordings: what is missing has bent them
    """
    return Search(model, runs, list(effects), loose).run()


class Search:
    """One search: the recordings made ready once, and hypotheses tried on them.

    as_given, again  the model without any effect more, as it is and fitted again;  before: what predicts better
    """

    def __init__(self, model: Model, runs: Runs, effects: Sequence[type[Effect]], loose: Collection[str]) -> None:
        self.model, self.runs = model, runs
        self.loose = [path for path in model.free() if path.partition(".")[0] in loose]
        self.wide, self.candidates = candidates(model, runs.rig, effects)
        runs.progress("reading the misfit", 0.0)
        self.trials = slow_trials_of(self.wide, runs)
        self.as_given = self._refined([], False)
        runs.progress("fitting the model again", 0.05)
        self.again = self._refined([], True)
        self.before = min(self.as_given, self.again, key=lambda h: h.misfit)

    def run(self) -> Suggestion:
        """All stages, and the verdict."""
        progress = self.runs.progress
        progress("screening the catalogue", 0.15)
        found = screening(self.model, self.wide, self.candidates, self.trials, self.loose)
        progress("fitting the best effects", 0.4)
        fitted, pair = self._fitted(found), self._pair(found)
        best = min([pair[1], *(h.misfit for h in fitted)])
        progress("looking for a wrong input", 0.75)
        wrong = self._wrong(best)
        progress("looking for something unknown", 0.85)
        rivals = [self.before.misfit, best, *([wrong.judged.misfit] if wrong else [])]
        unexplained = self._unexplained(min(rivals))
        return self._verdict(fitted, pair, wrong, unexplained, found)

    def _fitted(self, found: Screening) -> list[Hypothesis]:
        """The best effects of the screen, fitted in full, best first; each in the way that predicts better."""
        tried = []
        for refit in (False, True):
            for rank, one in enumerate(found.best(refit)):
                if rank < REFINED or (one.candidate.body and refit):
                    tried.append(self._refined([one.candidate], refit, one.first[refit]))
        best: dict[str, Hypothesis] = {}
        for each in sorted(tried, key=lambda h: h.misfit):
            best.setdefault(each.names[0], each)
        return list(best.values())

    def _refined(
        self, added: Sequence[Candidate], refit: bool, first: Mapping[str, float] = NONE, also: Sequence[str] = ()
    ) -> Hypothesis:
        """Some effects more, beside what moves anyhow."""
        only = [*self.loose, *also]
        return refined(self.model, self.trials, added, refit, first, only)

    def _pair(self, found: Screening) -> tuple[tuple[str, ...], float]:
        """The best two effects together, and their misfit; no names where there are none."""
        seats = {s.candidate.name: s.candidate for refit in (True, False) for s in found.best(refit)[: 2 * REFINED]}
        own = [Column(self.wide, path) for path in self.model.free()]
        loose = [i for i, column in enumerate(own) if column.path in self.loose]
        columns, at = list(own), {}
        for name, seat in seats.items():
            at[name] = range(len(columns), len(columns) + len(seat.paths))
            columns += [Column(seat.place(self.wide), path) for path in seat.paths]
        panel = Panel.of(self.trials, self.wide, columns)
        best: tuple[tuple[str, ...], float] = ((), np.inf)
        for a, b in combinations(seats, 2):
            for beside in (loose, range(len(own))):
                misfit = panel.judge([*beside, *at[a], *at[b]]).misfit
                if misfit < best[1]:
                    best = ((a, b), misfit)
        return best

    def _wrong(self, best: float) -> Mislabel | None:
        """A wrong input that explains clearly more than any effects."""
        if best <= GOOD:
            return None
        found = [mislabel(self.model, self.runs, self.trials, free) for free in (self.loose, self.model.free())]
        known = [each for each in found if each is not None]
        if not known:
            return None
        least = min(known, key=lambda m: m.judged.misfit)
        return least if least.judged.misfit < min(MATERIAL * self.before.misfit, best / ALIKE) else None

    def _unexplained(self, best: float) -> Screened | None:
        """What explains clearly more than the best effects or a wrong input, and is in no catalogue."""
        if best <= GOOD:
            return None
        wide, unknown = candidates(self.model, self.runs.rig, [UnknownHeat, UnknownBodyHeat, UnknownReading])
        found = screening(self.model, wide, unknown, self.trials, self.loose)
        both = [(one, refit) for refit in (False, True) for one in found.best(refit)[:1]]
        if not both:
            return None
        one, refit = min(both, key=lambda pair: pair[0].judged[pair[1]].misfit)
        least = STRANGE if len(self.trials) > 1 else ALONE
        return one if one.judged[refit].misfit < least * best else None

    def _verdict(
        self, fitted: list[Hypothesis], pair: tuple[tuple[str, ...], float], wrong: Mislabel | None,
        unexplained: Screened | None, screened: Screening,
    ) -> Suggestion:  # fmt: skip
        two = pair[0] if fitted and pair[1] < MATERIAL * fitted[0].misfit else ()
        if two and not set(two) & {fitted[0].names[0]}:
            fitted = sorted(fitted, key=lambda h: h.names[0] not in two)
        found: list[Hypothesis] = []
        wrong = None if unexplained is not None else wrong  # it leaves clearly more
        far = self._far(wrong.judged if wrong else self.before.judged)
        if wrong is not None:
            verdict = "input_error"
        elif unexplained is not None:
            verdict = "nothing_in_catalogue"
        else:
            found = self._few(fitted, screened) or [h for h in fitted if material(h, self.as_given, self.again)]
            verdict = "effect" if found else "nothing_in_catalogue" if far else "nothing_missing"
        tie = tuple(h.names[0] for h in found if alike(h, found[0]))
        verdict = "tie" if len(tie) > 1 else verdict
        rest = [h for h in fitted if h.names[0] not in {each.names[0] for each in found}]
        tied = tie if verdict == "tie" else ()
        uses = self.trials.uses
        return Suggestion(verdict, (*found, *rest), tied, self.as_given, self.again, uses, two, wrong, unexplained, far)

    def _far(self, judged: Explanation) -> bool:
        """Whether a model is so far off that something must be missing."""
        floor = noise_floor(self.model, self.trials[0])
        heat, length = np.fmax(GOOD_K, floor.temperature_K), np.fmax(GOOD_UM, floor.elongation_um)
        return bool(judged.error.temperature_K > FAR * heat or judged.read_um > FAR * length)

    def _few(self, fitted: list[Hypothesis], screened: Screening) -> list[Hypothesis]:
        """Effects, in the model or not, one of which alone explains nearly all that fitting all parameters again gains.

        One number that explains as much as many is the better explanation. None where a new fit gains little.
        """
        given, again = self.as_given.misfit, self.again.misfit
        gain, best = given - again, min([again, *(h.misfit for h in fitted)])
        enough = min(given - EXPLAINS * gain, FEW * best)
        if gain < (1 - MATERIAL) * given or given < GOOD:
            return []
        absent = [h for h in fitted if not h.refit and h.misfit <= enough]
        if not absent:
            return []
        own: dict[str, Hypothesis] = {}
        for path in sorted(screened.own, key=lambda p: screened.own[p].misfit)[:REFINED]:
            h = self._refined([], False, also=[path])
            name = path.partition(".")[0]
            if h.misfit <= enough and (name not in own or h.misfit < own[name].misfit):
                own[name] = replace(h, names=(name,))
        return sorted([*absent, *own.values()], key=lambda h: h.misfit)
