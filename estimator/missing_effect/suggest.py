"""Which effect is missing from a model, if it can be told.

Every hypothesis is judged by the open-loop misfit on recordings left out, temperatures and elongation alike:

    the model alone
    one effect more, or two
    one of its own parameters of another value
    one input set right, in one recording or in all
    something that began within one recording
    heat at some place, or an offset of a reading, that follows something (`unknown`)

all of them on either ground: what an earlier fit knows of the model's parameters holds, or only tables do (`ground`).
An effect must leave clearly less than the model does without it, and what leaves as little is named beside it as a tie.
What takes less than half off, and leaves the model far off, is not what is missing: it bends to what is.
Recordings held out are never looked at for this.
"""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from estimator.accuracy.noise_floor import noise_floor
from estimator.batch.trials import Trials, slow_trials_of
from estimator.effect import Effect
from estimator.hypotheses.candidates import kind_of
from estimator.hypotheses.criterion import APART_SE, GOOD, alike, behind, clearly, most, nats, proven
from estimator.hypotheses.ground import as_given, of_tables, seen
from estimator.hypotheses.hypothesis import Hypothesis, refined
from estimator.hypotheses.panel import Explanation
from estimator.missing_effect.begun import Begun, begun
from estimator.missing_effect.in_step import drifts_always, in_step, silenced
from estimator.missing_effect.odd_run import odd_run
from estimator.missing_effect.side import Side, each_once
from estimator.missing_effect.suggestion import Suggestion
from estimator.missing_effect.wrong_always import inputs_in, told
from estimator.missing_effect.wrong_input import Mislabel, mislabel, signals
from estimator.model import Model
from estimator.sensitivity.objective import GOOD_K, GOOD_UM
from estimator.unknown.composed import Composed, composed
from estimator.unknown.stand_ins import unknown_of
from estimator.unknown.unexplained import Unexplained, best_stand_in
from estimator.work import Runs, one_thread

FAR = 5.0  # times what a good model or the sensors leave, from which on something is missing, explained or not


@one_thread
def suggest(
    model: Model,
    runs: Runs,
    effects: Iterable[type[Effect]],
    loose: Collection[str] = (),
    healthy: Runs | None = None,
    taken: Collection[str] = (),
) -> Suggestion:
    """Look for what is missing.

    loose    effects of the model whose parameters were found from these recordings: what is missing has bent them
    healthy  recordings of the same machine in which nothing is missing: the model is fitted to them first, so that the
             question is what has changed since
    taken    names that an effect which no catalogue has must not get
    """
    if healthy is not None:
        model = refined(of_tables(model), slow_trials_of(model, healthy), []).known()
    return Search(model, runs, list(effects), loose, told=healthy is not None, taken=taken).run()


class Search:
    """One search: the recordings made ready once, and hypotheses tried on them.

    as_given, again  the model without any effect more: as it is, give or take what its fit left open; fitted again,
                     what it holds fixed too where that is worth its freedom
    others  the recordings made ready, where one more is left out already
    believed  thermometers that jump in step with the drive: what the judge says of them is not asked
    """

    def __init__(
        self,
        model: Model,
        runs: Runs,
        effects: Sequence[type[Effect]],
        loose: Collection[str],
        told: bool,
        others: Trials | None = None,
        taken: Collection[str] = (),
        believed: Sequence[str] | None = None,
    ) -> None:
        self.model, self.runs, self.effects = model, runs, effects
        self._loose, self._told, self._alone, self._taken = loose, told, others is not None, taken
        runs.progress("reading the misfit", 0.0)
        judged = others or slow_trials_of(model, runs)
        self.believed = in_step(judged.uses, runs.recordings, runs.rig) if believed is None else believed
        self.trials = judged if others or not self.believed else slow_trials_of(model, runs, self.believed)
        self.as_given = refined(as_given(model, runs, loose), self.trials, [])
        runs.progress("fitting the model again", 0.05)
        free = of_tables(model)
        grounds = [free, free.freed(*free.held)] if free.held else [free]
        self.again = min((refined(ground, self.trials, []) for ground in grounds), key=lambda h: h.cost)

    def run(self) -> Suggestion:
        """All stages, and the verdict."""
        self.runs.progress("looking for what is wrong with one run", 0.7)
        if (found := self._set_right()) is not None:
            return found
        self.runs.progress("looking for something unknown", 0.85)
        said = self._verdict(self._unexplained(self.side))
        said = replace(said, believed=tuple(self.believed))
        if self.believed and said.verdict == "nothing_missing":
            return self._by_jumps(said)
        return said if self.believed or self._alone else self._by_drifts(said)

    def _plains(self) -> list[Hypothesis]:
        """The model without effects on each ground that may hold.

        Parameters found from these very recordings are bent by what is missing: they cannot hold as they are.
        """
        if self._told:
            return [self.as_given]
        return [self.again] if seen(self.model, self.runs) else [self.as_given, self.again]

    @property
    def side(self) -> Side:
        """The ground that the recordings speak for."""
        return min(self.sides, key=lambda side: side.cost)

    @cached_property
    def sides(self) -> list[Side]:
        """Each ground that may hold; none that falls short whatever is fitted on it."""
        self.runs.progress("screening the catalogue", 0.15)
        sides = sorted(
            (Side(plain, self.trials, self.effects) for plain in self._plains()), key=lambda side: side.least
        )
        self.runs.progress("fitting the best effects", 0.4)
        return [side for side in sides if side is sides[0] or side.least < sides[0].cost]

    def _set_right(self) -> Suggestion | None:
        """What is wrong with one run where that explains clearly more than all else, and what the others say.

        The others alone are searched in for that: what is wrong with the one would have bent the answer.
        """
        at = None if self._alone else odd_run(self.side.here, self.trials)
        if at is None:
            return None
        others = self._without(at)
        here, best = others.side.here, self.side.best
        wrong = mislabel(here, self.runs, self.trials, at)
        if wrong and not clearly(self.side.loosest.judged, wrong.judged, self._times(wrong)):
            wrong = None  # a law of another exponent looks like a wrong speed in the only run of that speed
        if wrong and self._far(wrong.judged):
            wrong = None  # it bends to what is missing: set right, a run is well
        found = [wrong, begun(here, self.runs, self.trials, at)]
        sure = [one for one in found if one and clearly(best, one.judged, self._times(one))]
        if not sure:
            return None
        first, *rest = sorted(sure, key=lambda one: nats(one.judged, best) + np.log(self._times(one)))
        unexplained = self._unexplained(self.side) if first.judged.misfit > GOOD else None
        if unexplained is not None and unexplained.judged.misfit < first.judged.misfit:
            return None
        said = replace(others.run(), uses=self.trials.uses)
        return said.set_apart([first, *(one for one in rest if alike(one.judged, first.judged, 1))])

    def _without(self, at: int) -> "Search":
        """The same search in the other recordings."""
        some = [recording for i, recording in enumerate(self.runs.recordings) if i != at]

        def heard(stage: str, done: float) -> None:
            self.runs.progress(f"the other runs: {stage}", 0.7 + 0.15 * done)

        runs = replace(self.runs, recordings=some, progress=heard)
        ready = [trial for i, trial in enumerate(self.trials) if i != at]
        uses = tuple(use for i, use in enumerate(self.trials.uses) if i != at)
        others = Trials(ready, runs.workers, uses)
        return self._search(runs, others, self.believed)

    def _search(self, runs: Runs, others: Trials | None, believed: Sequence[str]) -> "Search":
        return Search(self.model, runs, self.effects, self._loose, self._told, others, self._taken, believed)

    def _times(self, found: Mislabel | Begun) -> float:
        """How many of its kind there are: inputs of each run, or effects that may begin in any ten minutes."""
        if isinstance(found, Mislabel):
            return float(len(self.runs.recordings) * len(signals(self.model, self.runs.rig)))
        blocks = np.count_nonzero(self.side.plain.judged.blocks[0])
        return float(self.side.tried * blocks) ** len(found.events)

    def _always(self, side: Side) -> Mislabel | None:
        """An input that is wrong in all recordings: what explains most, alone or as one of two."""
        best = side.pair if side.pair and inputs_in(side.pair.names) else side.missing[0] if side.missing else None
        if best is None or not inputs_in(best.names):
            return None
        rivals = [h for h in side.missing if h is not best and len(best.names) == 1]
        return None if any(alike(h.judged, best.judged, side.tried) for h in rivals) else told(best)

    def _unexplained(self, side: Side) -> Unexplained | None:
        """What explains clearly more than any one effect, and is in no catalogue.

        Two effects may compose it: heat at a place while driving, and less there always, is heat at rest. Where the
        model is far off all the same, something is missing: the question is not whether, but what it is like. Where
        little is left and readings seem to be wrong, they may be so by another law.
        """
        little, rig = side.best.misfit <= GOOD and not side.pair, self.runs.rig
        if little and not self._reads(side):
            return None
        found = best_stand_in(side.ground, self.trials, ["", *rig.names] if little else ())
        if found is None:
            return None
        if side.pair and clearly(found.judged, side.pair.judged, side.tried):
            return None
        return found if proven(side.single, found.judged, self._chosen_from(found)) else None

    def _reads(self, side: Side) -> bool:
        """Whether what explains most is what readings make of the temperatures."""
        return {kind_of(h.model, n, self.runs.rig) for h in side.told[:1] for n in h.names} == {"reading"}

    def _by_jumps(self, said: Suggestion) -> Suggestion:
        """What thermometers follow that jump whenever the drive starts or stops: that there is something is told."""
        most_of_them = len(self.believed) > len(self.runs.rig.thermometers) / 2
        one_of = ["", *self.believed] if most_of_them else self.believed  # "": all alike
        plain, found = self.side.plain.judged, best_stand_in(self.side.ground, self.trials, channels=one_of)
        if found is None or behind(plain, found.judged) < APART_SE:
            return said
        made = composed(found, plain, self.trials, [*self.model.effects, *self._taken])
        return replace(said, verdict="nothing_in_catalogue", unexplained=found, composed=made)

    def _by_drifts(self, said: Suggestion) -> Suggestion:
        """What is said when thermometers that drift in every run are heard throughout, or never."""
        names = drifts_always(self.trials.uses, self.runs.rig)
        unsaid = said.unexplained is None and self._far(self.side.single)
        if names and (unsaid or self._channel(said) in names):  # what they read before they were left out hides it
            other = self._search(silenced(self.runs, names), None, ()).run()
            return said if other.verdict == "nothing_missing" else replace(other, uses=self.trials.uses)
        if not names or not (said.verdict == "nothing_missing" or self._reads(self.side)):
            return said
        other = (again := self._search(self.runs, None, names)).run()
        return other if self._channel(other) is not None or again._reads(again.side) else said

    def _channel(self, said: Suggestion) -> str | None:
        return None if said.unexplained is None else unknown_of(said.unexplained.candidate, self.runs.rig).channel

    def _chosen_from(self, found: Unexplained) -> int:
        """How many stand-ins it must stand out from; none where something must be missing."""
        return 1 if self._far(self.side.single) else found.tried

    def _composed(self, found: Unexplained) -> Composed | None:
        """The effect that something unknown is, its numbers open, if it explains more than others and than chance."""
        self.runs.progress("composing an effect", 0.9)
        made = composed(found, self.side.plain.judged, self.trials, [*self.model.effects, *self._taken])
        if made is None:
            return None
        left, side = made.hypothesis.judged, self.side
        beyond_chance = proven(side.plain.judged, left, found.tried)
        return made if beyond_chance and clearly(side.single, left, self._chosen_from(found)) else None

    def _verdict(self, unexplained: Unexplained | None) -> Suggestion:
        side, found = self.side, self.side.told
        wrong = self._always(side) if unexplained is None else None
        far = self._far(wrong.judged if wrong else side.plain.judged)
        named = list(
            dict.fromkeys(h.names[0] for h in found if h is found[0] or alike(h.judged, found[0].judged, side.tried))
        )
        changed, partly, pair = "", "", side.pair
        both = pair is not None and len({*pair.names} - {*named}) != 1  # or one of them is what is named
        if wrong is not None:
            verdict, found = "input_error", []
        elif unexplained is not None:
            verdict, found = "nothing_in_catalogue", []
        elif pair and both:
            verdict, found = "effects", [pair]
        elif (own := self._own(side, named)) is not None:
            verdict, changed, found = "nothing_missing", own.freed, [own, *(h for h in found if h is not own)]
        elif found and self._far(found[0].judged) and not most(side.plain.judged, found[0].judged):
            verdict, partly = "nothing_in_catalogue", named[0]
        elif found:
            verdict = "tie" if len(named) > 1 else "effect"
        else:
            verdict = "nothing_in_catalogue" if far else "nothing_missing"
        names = [h.names for h in found]
        rest = sorted((h for one in self.sides for h in one.fitted if h.names not in names), key=lambda h: h.misfit)
        return Suggestion(
            verdict, (*found, *each_once(rest)), tuple(named) if verdict == "tie" else (), self.as_given, self.again,
            side.plain, self.trials.uses, changed, tuple(pair.names) if pair else (),
            wrong, unexplained, self._composed(unexplained) if unexplained else None, far=far, partly=partly,
        )  # fmt: skip

    def _own(self, side: Side, named: Sequence[str]) -> Hypothesis | None:
        """The own parameter of another value that all comes to that is named; None where it comes to more.

        An effect that does what an own parameter does is that parameter, where nothing stands out beside it.
        """
        doubles = set() if side.pair else side.doubles
        if not all(name in self.model.effects or name in doubles for name in named):
            return None
        return next((h for h in side.missing if h.freed and h.names[0] in named), None)

    def _far(self, judged: Explanation) -> bool:
        """Whether a model is so far off that something must be missing."""
        floor = noise_floor(self.model, self.trials[0])
        heat, length = np.fmax(GOOD_K, floor.temperature_K), np.fmax(GOOD_UM, floor.elongation_um)
        return bool(judged.error.temperature_K > FAR * heat or judged.read_um > FAR * length)
