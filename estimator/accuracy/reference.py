"""What an elongation is compared with where the truth is not known: readings of the displacement, joined at each stop.

The reading's zero is another one in a drive, where the turning screw is read at the stroke centre, and at rest, where
it is read directly. What joins them is what the model alone leaves of both, which is nearly the same just before and
just after: a line through half a minute of it, on each side, goes to the moment between.

    left = reading - the model alone, shifted in each drive and rest to begin where the one before ended; 0 at the start
    reference = the model alone + left

The growth itself bends within seconds of a stop, and is far from a line. So the model stands for a few seconds around
each stop, and for nothing else.
"""

from __future__ import annotations

import numpy as np

from estimator.accuracy.displacement import Joined, Stop, level
from estimator.batch.trial import Posed, Trial
from estimator.inputs.phase import phases
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig

EDGE_S = 30.0  # seconds of each stretch through which the line goes


def left_alone(recording: Recording, rig: Rig, model: Model, alone: Array) -> Joined:
    """What the model alone leaves of the displacement readings; nothing where the rig has no such channel.

    alone  (K,) what the channel would read by the model alone, um, NaN before the start; growth, if it does not say
    """
    scatter = model["displacement.sd"] if "displacement.sd" in model.values else 0.0
    if "displacement" not in rig.channels:
        return _unread((len(recording),), scatter)
    at = rig.index("displacement")
    late = np.diff(alone, prepend=alone[:1]) * np.clip(recording.ages_s[:, at] / rig.tick_s, 0.0, 1.0)
    held, direct = _readings(recording, rig)
    return _joined(held - alone + late, direct - alone, recording, rig, scatter)


def grown(trial: Trial, posed: Posed, model: Model) -> Array:
    """The reference at the ticks of a trial, (T,) um since its start; NaN where nothing is read."""
    run, rig = posed.run, trial.rig
    alone = np.append(0.0, run.grown)
    if "displacement" in rig.channels and np.isfinite(posed.forcing.readings.sd[at := rig.index("displacement")]):
        alone = np.append(run.spot[0, at], run.lagged[:, at]) + posed.offset[:, at]
    alone = np.append(np.full(trial.begin - 1, np.nan), alone)
    return run.grown + left_alone(trial.recording, rig, model, alone).um[trial.begin :]


def slopes(reads: Array, trial: Trial) -> Array:
    """How that moves, (k, T), when what the displacement would read by the model alone moves by each of `reads`."""
    if "displacement" not in trial.rig.channels:
        return np.full_like(reads, np.nan)
    alone = np.pad(reads.T, ((1, 0), (0, 0)))
    alone = np.pad(alone, ((trial.begin - 1, 0), (0, 0)), constant_values=np.nan)
    read = _readings(trial.recording, trial.rig)
    held, direct = (np.where(np.isfinite(each)[:, None], alone, np.nan) for each in read)
    return _joined(held, direct, trial.recording, trial.rig, 0.0).um[trial.begin :].T


def _unread(shape: tuple[int, ...], scatter: float) -> Joined:
    return Joined(np.full(shape, np.nan), np.full(shape[0], np.nan), scatter)


def _readings(recording: Recording, rig: Rig) -> tuple[Array, Array]:
    """Readings of a drive and at rest, (K,) um each."""
    held = recording.channels[:, rig.index("displacement")]
    return held, recording.inputs.get("displacement_direct", held)


def _joined(held: Array, direct: Array, recording: Recording, rig: Rig, scatter: float) -> Joined:
    """Drives and rests of a recording, shifted to begin where the one before ended; of readings (K,), or (K, k)."""
    out, end = _unread(held.shape, scatter), Stop(0.0, 0.0)
    time_s, age_s = recording.time_s, recording.ages_s[:, rig.index("displacement")]
    for driving, ticks in phases(recording):
        if driving:
            end = _join(held, time_s - age_s, time_s, ticks, end, out)
        else:
            end = _join(direct, time_s, time_s, _settled(ticks, recording), end, out)
    return out


def _settled(ticks: Array, recording: Recording) -> Array:
    """A rest without its last tick, where a drive follows: the screw may have turned when that was read."""
    return ticks if ticks[-1] + 1 == len(recording) else ticks[:-1]


def _join(left: Array, read_at: Array, time_s: Array, ticks: Array, before: Stop, out: Joined) -> Stop:
    """Fill one drive or rest, shifted to join the level at which the one before ended; returns its own last level."""
    read = ticks[np.isfinite(left[ticks]).all(axis=tuple(range(1, left.ndim)))]
    if not len(read):
        return before
    began = time_s[ticks[0] - 1] if ticks[0] else time_s[0]
    first, last = (level(read_at[read], left[read], at_s, EDGE_S) for at_s in (began, time_s[ticks[-1]]))
    zero = before.noise + first.noise
    out.um[read], out.noise[read] = left[read] - first.um + before.um, zero + 1.0
    return Stop(last.um - first.um + before.um, zero + last.noise)
