"""What a model predicts one sample ahead, minutes ahead, and from the start on: the errors it is judged by.

One-step error alone flatters: a filter that trusts its readings hides what its model lacks. Open loop nothing helps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator import batch
from estimator.follow import open_loop_misfit
from estimator.model import Model
from estimator.record import Array
from estimator.trial import Trial

AHEAD_S = 600.0
EVERY_S = 60.0
HORIZONS = ("one_step", "ahead", "open_loop")


@dataclass(frozen=True)
class Error:
    """An rms over thermometers, K, and over the displacement, um; NaN where there is none."""

    temperature_K: float
    elongation_um: float


@dataclass(frozen=True)
class Horizons:
    """Reading minus prediction at the ticks after the first sample, (T, m) each; NaN where not measured or refused.

    one_step   predicted from all readings up to the tick before; a reading that first tells its own zero is left out
    ahead      from those up to ten minutes before, once a minute, likewise
    open_loop  from the first sample alone; an unknown zero is taken out as the run's mean
    """

    one_step: Array
    ahead: Array
    open_loop: Array
    thermometers: Array

    def error(self, horizon: str) -> Error:
        """rms of one horizon."""
        return overall([self], horizon)


def horizons(trial: Trial, model: Model) -> Horizons:
    """All three predictions of one model on one recording."""
    posed = trial.pose(model)
    system = posed.system
    y = np.where(trial.muted, np.nan, system.y)
    told = np.cumsum(np.isfinite(y), axis=0)
    told[:, [i for i in range(y.shape[1]) if i not in trial.unread_zeros]] += 1
    one_step = y - np.vstack([chunk.predicted for chunk in batch.passes(system)])
    one_step[told <= 1] = np.nan
    tick_s = trial.rig.tick_s
    steps, every = round(AHEAD_S / tick_s), max(1, round(EVERY_S / tick_s))
    ahead = np.full_like(y, np.nan)
    if len(y) > steps:
        starts, predicted = batch.ahead(system, steps, every)
        ahead[starts + steps] = np.where(told[starts] > 0, y[starts + steps] - predicted, np.nan)
    open_loop = open_loop_misfit(trial, posed)
    thermometers = np.isin(trial.rig.names, trial.rig.thermometers)
    return Horizons(one_step, ahead, open_loop, thermometers)


def open_loop_only(trial: Trial, model: Model) -> Horizons:
    """The open-loop prediction alone; nothing is known of the others."""
    open_loop = open_loop_misfit(trial, trial.pose(model))
    none = np.full_like(open_loop, np.nan)
    return Horizons(none, none, open_loop, np.isin(trial.rig.names, trial.rig.thermometers))


def overall(found: Sequence[Horizons], horizon: str) -> Error:
    """rms over several recordings together."""
    rests = [(getattr(each, horizon), each.thermometers) for each in found]
    return Error(_rms([rest[:, heat] for rest, heat in rests]), _rms([rest[:, ~heat] for rest, heat in rests]))


def errors(trials: Sequence[Trial], model: Model) -> dict[str, Error]:
    """Error of each horizon over several recordings together."""
    found = [horizons(trial, model) for trial in trials]
    return {name: overall(found, name) for name in HORIZONS}


def _rms(rests: Sequence[Array]) -> float:
    values = np.concatenate([rest[np.isfinite(rest)] for rest in rests])
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")
