"""Which parameters of a model drift from run to run.

Parameters are known together: one that wears takes others along that look like it. Of those whose values change, the
one whose change explains most of all runs together is told, and those that explain as much are named beside it; then it
may change from run to run while the others are asked again, until none has changed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.batch.trials import slow_trials_of
from estimator.errors import InputError, SetupError
from estimator.faults.use import Use
from estimator.hypotheses.moments import moments
from estimator.hypotheses.slopes import Column
from estimator.model import Model
from estimator.record import Array
from estimator.trend.course import Course, Direction, Known, directions
from estimator.trend.drift import FEWEST, Drift, drift, shape, tellable
from estimator.work import Runs

SURE = 0.05  # that anything is told of a machine that does not change
LEAST_GAIN = 9.0  # three sd: less is nothing that anybody would act on
ALIKE = 6.0  # twice ln 20: what explains less than this less is named beside the best
MOST = 4  # parameters that are told


@dataclass(frozen=True)
class Told:
    """What has changed, and what it may as well be."""

    drift: Drift
    or_else: tuple[str, ...]


@dataclass(frozen=True)
class Trend:
    """Every parameter's and effect's course over the runs in order of time, and what has changed.

    names, start_s  of the runs, R each; start_s in s since 1970, or their number where a log tells no date
    dated           whether all of them tell one, and not one for all
    undated         the names of those that tell none
    tellable        "rise", "step": changes that so many runs would tell, were they large enough
    uses            what was used of each
    """

    names: tuple[str, ...]
    start_s: Array
    dated: bool
    undated: tuple[str, ...]
    courses: tuple[Course, ...]
    told: tuple[Told, ...]
    tellable: frozenset[str]
    uses: tuple[Use, ...] = ()


def trend(model: Model, runs: Runs) -> Trend:
    """Follow a model's free parameters over runs of one machine.

    Fewer than six runs are an InputError; a model of which no fit has left an sd is a SetupError.
    """
    if len(runs.recordings) < FEWEST:
        raise InputError(f"a trend needs {FEWEST} recordings of one machine at least; here are {len(runs.recordings)}")
    if not any(model.values[path].sd for path in model.free()):
        why = "none of its parameters has an sd: nothing is known that a run could differ from"
        raise SetupError(
            f"{model.name}: {why}; fit it first, `ballscrew fit LOG... --model {model.name} -o fitted.toml`"
        )
    began = [recording.began_s for recording in runs.recordings]
    undated = tuple(recording.name for recording in runs.recordings if recording.began_s is None)
    dated = not undated and len({*began}) > 1
    order = np.argsort(np.array(began, dtype=float), kind="stable") if dated else np.arange(len(began))
    some = [runs.recordings[i] for i in order]
    runs.progress("reading the misfit of each run", 0.0)
    trials = slow_trials_of(model, Runs(runs.rig, some, runs.workers))
    runs.progress("following each parameter", 0.6)
    columns = [Column(model, path) for path in model.free()]
    known = Known(model, moments(trials, model, columns, model))
    start_s = np.array([float(r.began_s or 0.0) for r in some]) if dated else np.arange(float(len(some)))
    told: list[Told] = []
    asked = directions(model)
    while len(told) < MOST and (found := _next(known, asked, start_s, told)) is not None:
        told.append(found)
    all_ = tuple(known.course(one) for one in asked)
    clear = frozenset(tellable(start_s, len(asked), SURE))
    return Trend(tuple(r.name for r in some), start_s, dated, undated, all_, tuple(told), clear, trials.uses)


def _next(known: Known, asked: Sequence[Direction], start_s: Array, told: Sequence[Told]) -> Told | None:
    """What has changed most clearly beside what is told already."""
    names = [one.drift.course.name for one in told]
    beside = [one for one in asked if one.name in names]
    rest = [one for one in asked if one.name not in names]
    found = [(one, drift(known.course(one, beside), start_s, len(rest))) for one in rest]
    clear = [(one, each) for one, each in found if each is not None and each.p < SURE and each.gain > LEAST_GAIN]
    gains = [known.gain(one, shape(each.shape, each.run, start_s), beside) for one, each in clear]
    ranked = sorted(zip(gains, (each for _, each in clear), strict=True), key=lambda pair: -pair[0])
    if not ranked or ranked[0][0] < LEAST_GAIN:
        return None
    (most, best), *others = ranked
    return Told(best, tuple(each.course.name for gain, each in others if gain > most - ALIKE))
