"""What an elongation is compared with where the truth is not known: readings of the displacement, joined.

What a reading counts from, its zero, is not the same for all of them:

    while driving  the peak over a turn is held at the stroke centre: one zero for all drives, that of the disc's wobble
    at rest        the disc stands as it stopped: another zero for each rest

So the zero of the first drive is that of all drives, found once where the screw has not grown yet, and nothing adds up
from stop to stop. A rest is joined to the drive before it and to the one after it, and goes straight from one zero to
the other between; the last one keeps the first.

What joins is what the model alone leaves of the readings, which is nearly the same just before and just after; the
growth itself bends within seconds of a stop, and is far from a line.

    left = reading - the model alone
    reference = the model alone + left - zero, by a line through the left of half a minute on each side

So the model stands for a minute, and for nothing else. What cannot be known any better: the zero of all drives by the
scatter of the first half minute and of the rest before, its walk since, and what warm probes and a warm bar add by
coefficients that are known as well as the model says.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from estimator.accuracy.displacement import jig_doubt, levels
from estimator.batch.trial import Posed, Trial
from estimator.inputs.phase import phases
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.step import Track


class Joined(NamedTuple):
    """Measured elongation since the start, NaN where nothing was read.

    um     (K,) each reading by itself
    level  (K,) by a line through the readings of half a minute on each side
    sd     (K,) of that, um
    """

    um: Array
    level: Array
    sd: Array


class Stop(NamedTuple):
    """What is left where a drive or a rest begins or ends, um, of one run or (k,) of several, and its variance over
    that of one reading."""

    um: Any
    noise: Any

    def plus(self, other: "Stop") -> "Stop":
        """Both together, each with a scatter of its own."""
        return Stop(self.um + other.um, self.noise + other.noise)

    def minus(self, other: "Stop") -> "Stop":
        """What the other lacks."""
        return Stop(self.um - other.um, self.noise + other.noise)


class Stretch(NamedTuple):
    """A drive or a rest in which something was read: the ticks of it, what was left and when, and at both its ends."""

    driving: bool
    ticks: Array
    left: Array
    at_s: Array
    first: Stop
    last: Stop


def readings(recording: Recording, rig: Rig, model: Model, track: Track) -> Joined:
    """What was read of the elongation, as far as a model's track joins it."""
    alone = track.open_loop_um
    if "displacement" in rig.channels and np.isfinite(track.innovation_sd[:, at := rig.index("displacement")]).any():
        alone = track.open_loop[:, at]
    alone = np.where(np.cumsum(track.begins) == track.begins.sum(), alone, np.nan)
    left = left_alone(recording, rig, model, alone)
    return left._replace(um=track.open_loop_um + left.um, level=track.open_loop_um + left.level)


def left_alone(recording: Recording, rig: Rig, model: Model, alone: Array) -> Joined:
    """What the model alone leaves of the displacement readings; nothing where the rig has no such channel.

    alone  (K,) what the channel would read by the model alone, um, NaN before the start; growth, if it does not say
    """
    sd, walk = (model[path] if (path := f"displacement.{key}") in model.values else 0.0 for key in ("sd", "zero_walk"))
    nothing = np.full(len(recording), np.nan)
    if "displacement" not in rig.channels:
        return Joined(nothing, nothing, nothing)
    at = rig.index("displacement")
    late = np.diff(alone, prepend=alone[:1]) * np.clip(recording.ages_s[:, at] / rig.tick_s, 0.0, 1.0)
    held, direct = _readings(recording, rig)
    stretches = _stretches(held - alone + late, direct - alone, recording, rig)
    um, level, noise = (nothing.copy() for _ in range(3))  # noise: the level's variance over that of one reading
    for each, shift in _joined(stretches):
        line, own = levels(each.at_s, each.left, each.at_s)
        um[each.ticks], level[each.ticks], noise[each.ticks] = each.left + shift.um, line + shift.um, own + shift.noise
    anchored_s = next((each.at_s[0] for each in stretches if each.driving), recording.time_s[0])
    walked = walk**2 * np.abs(recording.time_s - anchored_s)
    return Joined(um, level, np.sqrt(sd**2 * noise + walked + jig_doubt(recording, model, anchored_s) ** 2))


def grown(trial: Trial, posed: Posed, model: Model) -> Joined:
    """The reference at the ticks of a trial, (T,) um since its start; NaN where none is."""
    run, rig = posed.run, trial.rig
    alone = np.append(0.0, run.grown)
    if "displacement" in rig.channels and np.isfinite(posed.forcing.readings.sd[at := rig.index("displacement")]):
        alone = np.append(run.spot[0, at], run.lagged[:, at]) + posed.offset[:, at]
    alone = np.append(np.full(trial.begin - 1, np.nan), alone)
    left = Joined(*(each[trial.begin :] for each in left_alone(trial.recording, rig, model, alone)))
    return left._replace(um=run.grown + left.um, level=run.grown + left.level)


def slopes(reads: Array, trial: Trial) -> Array:
    """How that moves, (k, T), when what the displacement would read by the model alone moves by each of `reads`."""
    if "displacement" not in trial.rig.channels:
        return np.full_like(reads, np.nan)
    alone = np.pad(reads.T, ((1, 0), (0, 0)))
    alone = np.pad(alone, ((trial.begin - 1, 0), (0, 0)), constant_values=np.nan)
    held, direct = (np.where(np.isfinite(r)[:, None], alone, np.nan) for r in _readings(trial.recording, trial.rig))
    um = np.full_like(alone, np.nan)
    for each, shift in _joined(_stretches(held, direct, trial.recording, trial.rig)):
        um[each.ticks] = each.left + shift.um
    return um[trial.begin :].T


def _readings(recording: Recording, rig: Rig) -> tuple[Array, Array]:
    """Readings of a drive and at rest, (K,) um each."""
    held = recording.channels[:, rig.index("displacement")]
    return held, recording.inputs.get("displacement_direct", held)


def _stretches(held: Array, direct: Array, recording: Recording, rig: Rig) -> list[Stretch]:
    """Drives and rests of a recording in which something was read, of (K,), or of (K, k)."""
    time_s, age_s = recording.time_s, recording.ages_s[:, rig.index("displacement")]
    found = []
    for driving, ticks in phases(recording):
        left, read_s = (held, time_s - age_s) if driving else (direct, time_s)
        ends = time_s[[max(ticks[0] - 1, 0), ticks[-1]]]
        if not driving and ticks[-1] + 1 < len(time_s):
            ticks = ticks[:-1]  # a drive follows: the screw may have turned when that was read
        read = ticks[np.isfinite(left[ticks]).all(axis=tuple(range(1, left.ndim)))]
        if len(read):
            stops = (Stop(um, float(noise)) for um, noise in zip(*levels(read_s[read], left[read], ends), strict=True))
            found.append(Stretch(driving, read, left[read], read_s[read], *stops))
    return found


def _joined(stretches: list[Stretch]) -> Iterator[tuple[Stretch, Stop]]:
    """Each with what shifts it to what it counts from."""
    end, zero = Stop(0.0, 0.0), None
    for k, each in enumerate(stretches):
        begin = zero if each.driving and zero is not None else end.minus(each.first)
        zero = begin if each.driving else zero
        shift = close = begin
        after = next((it for it in stretches[k + 1 : k + 2] if it.driving), None)
        if zero is not None and after is not None:
            close = after.first.plus(zero).minus(each.last)
            shift = _between(begin, close, zero.noise, each)
        yield each, shift
        end = each.last.plus(close)


def _between(begin: Stop, close: Stop, common: float, each: Stretch) -> Stop:
    """What is added to readings of a rest, straight from its begin to its close, of whose noise some is common."""
    length = each.at_s[-1] - each.at_s[0]
    share = (each.at_s - each.at_s[0]) / length if length else np.zeros(1)
    noise = common + (1.0 - share) ** 2 * (begin.noise - common) + share**2 * (close.noise - common)
    share = share.reshape(-1, *[1] * (each.left.ndim - 1))
    return Stop(begin.um + share * (close.um - begin.um), noise)
