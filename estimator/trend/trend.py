"""Which parameters of a model drift from run to run.

Parameters are known together: one that wears takes others along that look like it. The one whose change explains most
is told, and those that explain as much are named beside it; then it may change from run to run while the others are
asked again, until none has changed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.batch.trials import slow_trials_of
from estimator.errors import InputError
from estimator.faults.use import Use
from estimator.hypotheses.moments import Moments, moments
from estimator.hypotheses.slopes import Column
from estimator.model import Model
from estimator.record import Array
from estimator.trend.course import Course, courses
from estimator.trend.drift import FEWEST, Drift, drift
from estimator.work import Runs

SURE = 0.05  # that anything is told of a machine that does not change
ALIKE = 6.0  # twice ln 20: what explains less than this less is named beside the best
MOST = 4  # parameters that are told


@dataclass(frozen=True)
class Told:
    """A parameter that has changed, and others of which it may as well be."""

    drift: Drift
    or_else: tuple[str, ...]


@dataclass(frozen=True)
class Trend:
    """Every parameter's course over the runs in order of time, and what has changed.

    names, start_s  of the runs, R each; start_s in s since 1970, or their number where a log tells no date
    dated           whether all of them tell one, each its own
    uses            what was used of each
    """

    names: tuple[str, ...]
    start_s: Array
    dated: bool
    courses: tuple[Course, ...]
    told: tuple[Told, ...]
    uses: tuple[Use, ...] = ()


def trend(model: Model, runs: Runs) -> Trend:
    """Follow a model's free parameters over runs of one machine; fewer than six runs are an InputError."""
    if len(runs.recordings) < FEWEST:
        raise InputError(f"a trend needs {FEWEST} recordings of one machine at least; here are {len(runs.recordings)}")
    began = [recording.began_s for recording in runs.recordings]
    dated = None not in began and len({*began}) == len(began)
    order = np.argsort(np.array(began, dtype=float), kind="stable") if dated else np.arange(len(began))
    some = [runs.recordings[i] for i in order]
    runs.progress("reading the misfit of each run", 0.0)
    trials = slow_trials_of(model, Runs(runs.rig, some, runs.workers))
    runs.progress("following each parameter", 0.6)
    columns = [Column(model, path) for path in model.free()]
    found = moments(trials, model, columns, model)
    start_s = np.array([float(r.began_s or 0.0) for r in some]) if dated else np.arange(float(len(some)))
    all_ = courses(model, found, model.free())
    told: list[Told] = []
    while len(told) < MOST and (next_one := _next(model, found, start_s, all_, told)) is not None:
        told.append(next_one)
    return Trend(tuple(r.name for r in some), start_s, dated, tuple(all_), tuple(told), trials.uses)


def _next(
    model: Model, found: Sequence[Moments], start_s: Array, first: Sequence[Course], told: Sequence[Told]
) -> Told | None:
    """The parameter that has changed most clearly beside those that are told already."""
    moved = [one.drift.course.path for one in told]
    rest = [path for path in model.free() if path not in moved]
    asked = courses(model, found, rest, moved) if moved else first
    drifts = [one for course in asked if (one := drift(course, start_s, len(rest))) is not None and one.p < SURE]
    if not drifts:
        return None
    best = max(drifts, key=lambda one: one.gain)
    others = [one for one in drifts if one is not best and one.gain > best.gain - ALIKE]
    return Told(best, tuple(one.course.path for one in sorted(others, key=lambda one: -one.gain)))
