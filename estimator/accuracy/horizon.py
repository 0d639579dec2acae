"""What a model predicts one sample ahead, minutes ahead, and from the start on: the errors it is judged by.

One-step error alone flatters: a filter that trusts its readings hides what its model lacks. Open loop nothing helps.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.accuracy.accuracy import rms
from estimator.accuracy.noise_floor import Error
from estimator.accuracy.reference import grown
from estimator.batch import batch
from estimator.batch.open_loop import open_loop_misfit
from estimator.batch.trial import Posed, Trial, with_elongation
from estimator.batch.trials import Trials
from estimator.inputs.phase import phase_of
from estimator.model import Model
from estimator.record import Array

AHEAD_S = 600.0
EVERY_S = 60.0
HORIZONS = ("one_step", "ahead", "open_loop")


@dataclass(frozen=True)
class Horizons:
    """Reading minus prediction at the ticks after the first sample, (T, m) each; NaN where not measured or refused.

    one_step   predicted from all readings up to the tick before; a reading that first tells its own zero is left out
    ahead      from those up to ten minutes before, once a minute, likewise
    open_loop  from the first sample alone; an unknown zero is taken out as the run's mean
    elongation (T,) predicted elongation, um, by each of these names, NaN where nothing was predicted
    reference  (T,) what each is compared with; where it is not known, readings of the displacement stand for it
    """

    one_step: Array
    ahead: Array
    open_loop: Array
    thermometers: Array
    elongation: Mapping[str, Array]
    reference: Mapping[str, Array]

    def where(self, mask: Array) -> "Horizons":
        """The same at some of the ticks."""
        elongation, reference = (
            {name: each[mask] for name, each in by.items()} for by in (self.elongation, self.reference)
        )
        return Horizons(
            self.one_step[mask], self.ahead[mask], self.open_loop[mask], self.thermometers, elongation, reference
        )

    def temperature_errors(self, horizon: str) -> Array:
        """Of every thermometer, (T, thermometers) K."""
        return np.asarray(getattr(self, horizon)[:, self.thermometers])

    def elongation_errors(self, horizon: str) -> Array:
        """Reference minus prediction, or else reading minus prediction, um: (T, 1 + displacements), NaN for none."""
        readings = getattr(self, horizon)[:, ~self.thermometers]
        return _elongation_errors(self.reference[horizon], self.elongation[horizon], readings)


def horizons(trial: Trial, model: Model, truth: Array | None = None) -> Horizons:
    """All three predictions of one model on one recording; `truth`: (K,) true elongation at its ticks, um."""
    posed = trial.pose(model)
    system = posed.system
    long = with_elongation(posed.system, posed.state)
    y = np.where(trial.muted, np.nan, system.y)
    told = np.cumsum(np.isfinite(y), axis=0)
    told[:, [i for i in range(y.shape[1]) if i not in trial.unread_zeros]] += 1
    filtered = batch.compared(long, spread=False)
    one_step = y - filtered.predicted[:, :-1]
    one_step[told <= 1] = np.nan
    elongation = {"one_step": filtered.predicted[:, -1], "ahead": np.full(len(y), np.nan), "open_loop": posed.run.grown}
    tick_s = trial.rig.tick_s
    steps, every = round(AHEAD_S / tick_s), max(1, round(EVERY_S / tick_s))
    ahead = np.full_like(y, np.nan)
    if len(y) > steps:
        starts, predicted = batch.ahead(long, filtered.x, steps, every)
        ahead[starts + steps] = np.where(told[starts] > 0, y[starts + steps] - predicted[:, :-1], np.nan)
        elongation["ahead"][starts + steps] = predicted[:, -1]
    thermometers = trial.rig.is_thermometer
    reference = _references(trial, posed, model, truth)
    return Horizons(one_step, ahead, open_loop_misfit(trial, posed), thermometers, elongation, reference)


def _references(trial: Trial, posed: Posed, model: Model, truth: Array | None) -> dict[str, Array]:
    """What predictions of the elongation are compared with.

    Where it is not true, it is from readings; not where a prediction is made from the readings before and so is held
    against the next of them itself, as long as they come.
    """
    if truth is not None:
        return dict.fromkeys(HORIZONS, truth[trial.begin :])
    measured, read = grown(trial, posed, model).level, np.isfinite(trial.rest.channels[:, ~trial.rig.is_thermometer])
    unread = np.where(read.any(axis=1) | (phase_of(trial.rest) == "drive"), np.nan, measured)
    return {"one_step": unread, "ahead": unread, "open_loop": measured}


def open_loop_error(model: Model, trials: Trials) -> Error:
    """rms by the model alone over several recordings together, as `errors` has it."""

    heat = trials[0].rig.is_thermometer

    def misfits(trial: Trial) -> tuple[Array, Array]:
        posed = trial.pose(model)
        rest, reference = open_loop_misfit(trial, posed), grown(trial, posed, model).level
        return rest[:, heat], _elongation_errors(reference, posed.run.grown, rest[:, ~heat])

    return Error(*(rms(np.concatenate(some)) for some in zip(*trials.each(misfits), strict=True)))


def _elongation_errors(reference: Array, predicted: Array, readings: Array) -> Array:
    """Reference minus prediction (T,); where there is no reference, what readings (T, displacements) are off by."""
    return np.column_stack([reference - predicted, np.where(np.isfinite(reference)[:, None], np.nan, readings)])


def overall(found: Sequence[Horizons], horizon: str) -> Error:
    """rms over several recordings together."""
    families = (Horizons.temperature_errors, Horizons.elongation_errors)
    return Error(*(rms(np.concatenate([errors(each, horizon).ravel() for each in found])) for errors in families))


def errors(trials: Trials, model: Model) -> dict[str, Error]:
    """Error of each horizon over several recordings together."""
    found = trials.each(lambda trial: horizons(trial, model))
    return {name: overall(found, name) for name in HORIZONS}
