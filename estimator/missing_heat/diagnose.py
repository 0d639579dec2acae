"""Whether a model is adequate, where it fails, and what the failure follows; nothing is fitted.

The open-loop misfit is divided into heat that the model lacks, by place and time, and errors of single readings
(`missing_heat`). Both are held against what they may follow (`follows`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.accuracy.horizon import errors
from estimator.accuracy.noise_floor import Error, noise_floor, rms_by_family
from estimator.accuracy.quality import ChannelQuality, quality
from estimator.batch.trials import slowed, trials_of
from estimator.faults.sentences import sentences as not_used
from estimator.faults.use import Use
from estimator.inputs.phase import turns
from estimator.missing_heat.misfit import Misfit, misfit
from estimator.missing_heat.missing_heat import MissingHeat, missing_heat
from estimator.missing_heat.sentences import sentences
from estimator.missing_heat.where import SHADOW, Deficit, together, where
from estimator.missing_heat.wrong_reading import Wrong, wrong_readings
from estimator.model import Model
from estimator.sensitivity.objective import GOOD_K, GOOD_UM
from estimator.work import Runs, one_thread

FLOORS = 2.0  # times what the sensors leave


@dataclass(frozen=True)
class Diagnosis:
    """The answer and what it rests on.

    adequate  the model alone follows thermometers and displacement within `limits`, which are good enough
    errors    rms by horizon;  floor: what sensors leave
    quality   of the filter, channel by channel
    where, readings  missing heat and wrong readings that are sure and matter, largest first
    maps      the missing heat of each recording;  uses: what was used of it
    """

    adequate: bool
    errors: Mapping[str, Error]
    floor: Error
    limits: Error
    quality: tuple[ChannelQuality, ...]
    where: tuple[Deficit, ...]
    readings: tuple[Wrong, ...]
    sentences: tuple[str, ...]
    maps: tuple[MissingHeat, ...]
    uses: tuple[Use, ...]

    def __repr__(self) -> str:
        return "\n".join(self.sentences)


@one_thread
def diagnose(model: Model, runs: Runs) -> Diagnosis:
    """Judge a model by recordings."""
    rig, progress = runs.rig, runs.progress
    progress("running the filter", 0.0)
    trials = trials_of(model, runs)
    judged = quality(trials, model)
    found = errors(trials, model)
    progress("running the model alone", 0.3)
    misfits: list[Misfit] = trials.each(lambda trial: misfit(model, slowed(trial, model)))
    floor, uses = noise_floor(model, trials[0]), trials.uses
    del trials  # those of a day fill memory
    progress("looking for missing heat", 0.7)
    maps = missing_heat(misfits, runs.workers)
    progress("asking what it follows", 0.9)
    limits, alone = good_enough(floor), rms_by_family([each.open_loop for each in misfits], rig)
    heat, wrong = without_shadows(where(maps, limits), wrong_readings(maps, limits))
    adequate = not (alone.temperature_K > limits.temperature_K or alone.elongation_um > limits.elongation_um)
    moves = any(bool(turns(recording.omega).any()) for recording in runs.recordings)
    broken = any(use.suspects for use in uses)
    told = (*not_used(uses, rig), *sentences(adequate, found["open_loop"], floor, heat, wrong, moves, broken))
    return Diagnosis(adequate, found, floor, limits, judged, heat, wrong, told, tuple(maps), uses)


def good_enough(floor: Error) -> Error:
    """rms that is good enough: what a good model leaves, or a few times what the sensors leave, if that is more."""
    heat, length = np.fmax(GOOD_K, FLOORS * floor.temperature_K), np.fmax(GOOD_UM, FLOORS * floor.elongation_um)
    return Error(float(heat), float(length))


def without_shadows(heat: Sequence[Deficit], wrong: Sequence[Wrong]) -> tuple[tuple[Deficit, ...], tuple[Wrong, ...]]:
    """Findings without those that are small beside the largest; heat at one place in several phases stays together."""
    groups = together(heat)
    effects = [max(each.effect for each in group) for group in groups]
    least = SHADOW * max([0.0, *effects, *(each.effect for each in wrong)])
    kept = [each for group, effect in zip(groups, effects, strict=True) if effect >= least for each in group]
    kept.sort(key=lambda each: -abs(each.heat_W))
    return tuple(kept), tuple(each for each in wrong if each.effect >= least)
