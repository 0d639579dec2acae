"""Heat that comes and goes within minutes, on bodies: a lid that is opened, a fan that somebody turns towards them.

It lasts a few spans, which are finer than for what stays. Such spans would make the pattern of what is always wrong
with the model as large as themselves; it is sized without those that stand out of it:

    e = L^-1 y,    S = L L',    e^2 > 25 median(e^2) / 0.455

What a model makes wrong of a heater that switches seldom stands out as well: it is taken into account, and not told.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import scipy

from estimator.batch.trial import Trial
from estimator.batch.trials import Trials
from estimator.events.event import PART, Event
from estimator.events.kinds import told
from estimator.events.onset import ENDS, Onset, Solver, steps, worth
from estimator.events.pattern import pattern, sized
from estimator.events.signature import Signature, signature
from estimator.missing_heat.causes import Averages, covariance
from estimator.model import Model
from estimator.record import Array

AVERAGES, TICKS = 640, 10  # of all channels together; and in a span at least
FEWEST = 40  # averages, below which nothing is told
MOST = 10  # in one recording
SPANS = 5.0  # that it lasts at most
OUTLYING = 25.0  # squares of a standard deviation, as the median of all tells it
MEDIAN = 0.455  # of the square of what is normal with sd 1
ROUNDS = 2  # what stands out shows better when the worst of it is gone
SELDOM = 5.0  # times the median change of the heat that a model puts in from span to span
BEFORE, AFTER = 1.0, 2.0  # spans, within which of such a change what begins is the model's
OFTEN = 1 / 3  # of such changes, from which on what begins with them goes with them
WEAK = 0.2  # of the largest gain: less, beside a switch, is what the largest leaves
UNHEARD_K2 = 1e6  # variance of averages that are not to count


def short_heats(model: Model, trials: Trials, least: float) -> list[Event]:
    """What came and went; least: twice the log-likelihood that its beginning and its end add, each."""
    if any(trial.rig.screw is not None for trial in trials):
        return []  # a screw is too slow to show any
    seen = [each for each in trials.each(lambda trial: _finely(model, trial)) if len(each.y) >= FEWEST]
    heard = [pattern(each) for each in seen]
    sizes = sized(heard, trials.workers)
    for _ in range(ROUNDS):
        heard = [without_outlying(*each, sizes) for each in zip(seen, heard, strict=True)]
        sizes = sized(heard, trials.workers)
    found = trials.workers(lambda one: _found(one, sizes, least), seen)
    return [told(onset, one) for one, some in zip(seen, found, strict=True) for onset in some]


def _finely(model: Model, trial: Trial) -> Signature:
    lasts_s = float(trial.rest.time_s[-1] - trial.rest.time_s[0])
    return signature(model, trial, max(lasts_s * len(trial.rig.names) / AVERAGES, TICKS * trial.rig.tick_s))


def without_outlying(seen: Signature, measured: Averages, sizes: Mapping[str, float]) -> Averages:
    """Averages of which those spans do not count that stand out, by their innovations in the order of time."""
    factor = np.linalg.cholesky(covariance(measured, sizes))
    square = scipy.linalg.solve_triangular(factor, measured.y, lower=True) ** 2
    usual = np.median(square[np.diag(measured.known) < UNHEARD_K2]) / MEDIAN
    outlying = np.isin(seen.span, seen.span[square > OUTLYING * usual])
    return replace(measured, known=measured.known + np.diag(UNHEARD_K2 * outlying))


def _found(seen: Signature, sizes: Mapping[str, float], least: float) -> list[Onset]:
    """Of one recording, the most likely first."""
    heats = [step for step in steps(seen) if step.carrier is not None and step.acts.all()]
    span_s = float(np.median(np.diff(seen.spans.from_s)))
    found: list[Onset] = []
    switched = _switched(seen)
    while heats and len(found) < MOST:
        solver = Solver(pattern(seen, [onset.column for onset in found]), sizes, (0.9 * span_s, (SPANS + 0.1) * span_s))
        best = max(heats, key=lambda step: float(solver.gains(seen, step)[1].max()))
        onset = solver.onset(seen, best)
        if onset.until_s is None or onset.gain <= least + ENDS or not worth(onset, seen):
            break
        found.append(onset)
    alone = [onset for i, onset in enumerate(found) if not any(_with(onset, other) for other in found[:i])]
    near = [onset for onset in alone if _near(onset.since_s - switched, span_s)]
    times = 1 + np.count_nonzero(np.diff(switched) > AFTER * span_s)
    # a model that is wrong with its heat is so most times that it switches
    seldom = len(found) < MOST and len(near) <= OFTEN * times
    strong = WEAK * max((onset.gain for onset in alone), default=0.0)
    return [one for one in alone if not _near(one.since_s - switched, span_s) or (seldom and one.gain > strong)]


def _with(onset: Onset, other: Onset) -> bool:
    """Whether it only corrects one that is more likely: what is shorter than a span is not as it seems."""
    first, second = ((each.since_s, each.until_s or 0.0) for each in (onset, other))
    return onset.step is other.step and max(first[0], second[0]) < min(first[1], second[1])


def _near(after_s: Array, span_s: float) -> bool:
    return bool(((after_s > -BEFORE * span_s) & (after_s <= AFTER * span_s)).any())


def _switched(seen: Signature) -> Array:
    """When the heat that the model puts in jumps as it seldom does, (k,) s."""
    puts = [carrier.push for carrier in seen.carriers if carrier.kind == PART and not carrier.loses]
    if not puts:
        return np.empty(0)
    of_tick = seen.spans.of_tick
    first = np.flatnonzero(np.diff(of_tick, prepend=-1))
    mean = np.add.reduceat(np.hstack(puts), first) / np.bincount(of_tick)[:, None]
    jump = np.abs(np.diff(mean, axis=0)).sum(axis=1)
    return seen.spans.from_s[1:][jump > SELDOM * np.median(jump)]
