"""What the axis feels of a model: how far the filter's estimate is off while the rig cools and no length is read.

An error of the model alone is what shows that something is missing. The filter follows its readings all the same, so
that less of it reaches the compensation: little with thermometers, more where they fall silent too.
"""

from dataclasses import dataclass

import numpy as np

from estimator.accuracy.accuracy import Accuracy, accuracy
from estimator.accuracy.reference import readings
from estimator.accuracy.review import filter_error
from estimator.batch.replay import replay
from estimator.inputs.phase import COOLDOWN_S, cooling, stops
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.state.gate import Mute
from estimator.work import Runs


@dataclass(frozen=True)
class Felt:
    """Reference minus the filter's elongation in the 60 min after stops.

    A reading that the filter uses is compared with what it predicted before.

    seen   with what the thermometers read;  silent: without any reading from each stop on
    """

    seen: Accuracy
    silent: Accuracy


def felt(model: Model, runs: Runs) -> Felt | None:
    """Errors at the table by one model; None where no elongation is read at rest."""
    rig = runs.rig
    if "displacement" not in rig.channels:
        return None
    pairs = runs.each(lambda recording: _errors(model, rig, recording))
    seen, silent = (np.concatenate(errors) for errors in zip(*pairs, strict=True))
    return Felt(accuracy(seen), accuracy(silent)) if np.isfinite(seen).any() else None


def _errors(model: Model, rig: Rig, recording: Recording) -> tuple[Array, Array]:
    """Errors in cooldown, (K,) um each, NaN at other times: with thermometers, and without."""
    return _cooling(model, rig, recording, None), _cooling(model, rig, recording, _silent(recording, rig))


def _cooling(model: Model, rig: Rig, recording: Recording, mute: Mute | None) -> Array:
    track = replay(model, rig, recording, mute)
    return np.where(cooling(recording), filter_error(track, rig, readings(recording, rig, model, track)), np.nan)


def _silent(recording: Recording, rig: Rig) -> Mute:
    """Nothing is read for an hour from each stop on."""
    ends, none = np.array(stops(recording)), np.ones(len(rig.names), dtype=bool)
    return lambda time_s: none & bool(((ends < time_s) & (time_s <= ends + COOLDOWN_S)).any())
