"""The run that settles what a search has left open: how far its predictions differ on runs that were not made yet.

    D2 = min over changes d of b's parameters of  d' C d + misfit of b, so changed, to what a predicts

C is the curvature that the recordings at hand leave: rival b may move its parameters as far as they allow. D is by how
many standard deviations the new run sets a and b apart. Of several rivals the run counts by the two that it tells
worst.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations

import numpy as np

from estimator.batch.trial import Trial
from estimator.batch.trials import Trials, beside, slow_trials_of
from estimator.hypotheses.hypothesis import Hypothesis
from estimator.hypotheses.moments import Moments, moments_of
from estimator.hypotheses.panel import Panel
from estimator.hypotheses.slopes import Column
from estimator.missing_effect.suggestion import Suggestion
from estimator.model import Model
from estimator.next_run.foretold import lived, planned
from estimator.next_run.plans import Plan, plans
from estimator.next_run.question import Question, question
from estimator.next_run.surroundings import foretold, learned, mean_rise, mean_temperature
from estimator.record import Array
from estimator.work import Runs

TICK_S = 5.0
WARMER = 1.2  # times what the thermometers rose by so far: no run is asked for that heats the rig more
PAIRS = 3  # rivals of which all pairs are looked at; of more those with the best


@dataclass(frozen=True)
class NextRun:
    """A run to make, why, and what it is expected to tell.

    why            as in `Question`
    between        the two that it tells worst, of those that it is to set apart; of a badly known parameter its path
    separation_sd  by how many sd it sets them apart, with the recordings at hand; the parameter from nothing
    several        whether more than two are to be set apart
    """

    plan: Plan
    why: str
    between: tuple[str, ...]
    separation_sd: float
    several: bool = False


def next_run(found: Suggestion, runs: Runs) -> NextRun | None:
    """The run to make after a search; None where nothing is open, or nothing was ever driven or on."""
    tried = plans(runs.rig, runs.recordings)
    if not tried:
        return None
    ready = cache(lambda: slow_trials_of(found.as_given.model, runs))
    open_ = question(found, runs.rig, ready)
    return best_of(tried, open_, runs, ready()) if open_ else None


def best_of(tried: Sequence[Plan], open_: Question, runs: Runs, trials: Trials) -> NextRun:
    """The plan that tells most of what is open."""
    ask = _Asker(open_, runs, trials)
    rises = list(runs.workers(ask.warmest, tried))
    seen = max(float(mean_rise(run, runs.rig).max()) for run in runs.recordings)
    tried = [plan for plan, rise in zip(tried, rises, strict=True) if rise <= WARMER * seen] or tried
    told = list(runs.workers(ask.parameter if open_.path else ask.least, tried))
    best = int(np.argmax([apart for _, apart in told]))
    between, apart = told[best]
    return NextRun(tried[best], open_.why, between, float(apart), len(open_.rivals) > 2)


class _Asker:
    """What plans would tell, where the recordings at hand hold all parameters as far as they do."""

    def __init__(self, open_: Question, runs: Runs, trials: Trials) -> None:
        rig, recordings = runs.rig, runs.recordings
        self._open, self._laws, self._trials = open_, learned(recordings, rig), trials
        self._rig = replace(rig, tick_s=TICK_S)
        self._level = float(np.median([mean_temperature(r, rig)[0] for r in recordings]))
        self._known = {name: panel_of(h, trials) for name, h in open_.rivals}

    def least(self, plan: Plan) -> tuple[tuple[str, ...], float]:
        """The two rivals that a plan sets apart least, and by how many sd."""
        rivals, found = self._open.rivals, []
        with_best = [(rivals[0], other) for other in rivals[1:]]
        for (one, a), (other, b) in combinations(rivals, 2) if len(rivals) <= PAIRS else with_best:
            found.append(((one, other), self._known[other].with_another(self._moments(plan, a.model, b, other))))
        return min(found, key=lambda pair: pair[1])

    def parameter(self, plan: Plan) -> tuple[tuple[str, ...], float]:
        """By how many sd the parameter that is badly known would lie from nothing."""
        (name, h), path = self._open.rivals[0], self._open.path
        sd = self._known[name].sd_with_another(self._moments(plan, h.model, h, name))[h.paths.index(path)]
        return (path,), abs(float(h.model[path]) - (h.model.param(path).null or 0.0)) / float(sd)

    def _moments(self, plan: Plan, truth: Model, h: Hypothesis, name: str) -> Moments:
        """Moments of the plan about a hypothesis, if another model is the truth."""
        run = planned(plan, self._rig, self._level)
        rises = foretold(self._laws, self._mean_rise(truth, plan), run.omega, TICK_S)
        run = replace(run, inputs={**run.inputs, **{signal: self._level + rise for signal, rise in rises.items()}})
        trial = Trial(h.model, self._rig, lived(truth, run, self._rig, self._level), gated=False)
        return moments_of(beside(self._trials[0], trial), h.model, self._known[name].columns)

    def warmest(self, plan: Plan) -> float:
        """The most that thermometers rise by on the mean, K, as the best hypothesis foretells it."""
        return float(self._mean_rise(self._open.rivals[0][1].model, plan).max())

    def _mean_rise(self, truth: Model, plan: Plan) -> Array:
        """Rise of the thermometers, (K,), while the surroundings stay as they are."""
        first = lived(truth, planned(plan, self._rig, self._level), self._rig, self._level)
        return mean_rise(first, self._rig)


def panel_of(h: Hypothesis, trials: Trials) -> Panel:
    """What the recordings at hand say of a hypothesis' parameters."""
    columns = [Column(h.model, path) for path in h.paths]
    return Panel.of(trials, h.model, columns, h.ground.belief(h.model, h.paths))
