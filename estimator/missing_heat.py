"""The heat that would repair the open-loop run of a recording: where, when, how much, and how sure.

    y = A h + errors of the readings + scatter

h   W/m in each zone and block of time: unknown and smooth in place; the sum of four, each of a size that the
    recordings tell: steady, and smooth in time, at all times, and while driving
e   of each reading: a constant from the first motion on, and something that wanders within 20 minutes; the latter also
    of all thermometers together; each of a size that the recordings tell

All are Gaussian, so that the answer is exact given the sizes. One bad thermometer moves alone and at once; heat moves
its neighbours too, late, and the elongation: so the two are told apart, and both are kept.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.blocks import ALIKE_S, Blocks
from estimator.misfit import Misfit
from estimator.posterior import Share
from estimator.record import Array
from estimator.shares import Cause, Measured, Solved, most_likely, solved
from estimator.zones import Zone, alike

HEATS = ("heat", "heat while driving", "changing heat", "changing heat while driving")
ALL = "thermometers"
FIRST_W_M, LEAST_W_M = 5.0, 1e-3
FIRST_K, LEAST_K = 0.01, 0.01
FIRST_UM, LEAST_UM = 0.05, 0.05
ZERO_UM = 100.0  # sd of a zero that has no meaning


@dataclass(frozen=True)
class ReadingError:
    """What a reading shows beside the truth, over the blocks in which it was read: mean (b,), covariance (b, b)."""

    blocks: Array
    mean: Array
    covariance: Array


@dataclass(frozen=True)
class MissingHeat:
    """The answer for one recording.

    mean, sd    (B, Z) W/m; W for a zone that is a body
    covariance  (B Z, B Z) of them, block by block
    readings    error of each channel, and of all thermometers together ("thermometers"), by name
    sizes       of each cause, the same for all recordings
    """

    misfit: Misfit
    mean: Array
    covariance: Array
    readings: Mapping[str, ReadingError]
    sizes: Mapping[str, float]

    @property
    def blocks(self) -> Blocks:
        """When."""
        return self.misfit.blocks

    @property
    def zones(self) -> tuple[Zone, ...]:
        """Where."""
        return self.misfit.zones

    @property
    def sd(self) -> Array:
        """Standard deviation of `mean`."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0)).reshape(self.mean.shape)


def missing_heat(found: Sequence[Misfit], share: Share = map) -> list[MissingHeat]:
    """The missing heat of some recordings of one rig and model."""
    measured = [_measured(each) for each in found]
    rig = found[0].trial.rig
    first, least = dict.fromkeys(HEATS, FIRST_W_M), dict.fromkeys(HEATS, LEAST_W_M)
    for name in {name for each in measured for name in each.causes} - {*HEATS}:
        heat = name == ALL or name.partition(" ")[2] in rig.thermometers
        first[name], least[name] = (FIRST_K, LEAST_K) if heat else (FIRST_UM, LEAST_UM)
    sizes = most_likely(measured, first, least, share)
    return [_answer(each, one, sizes) for each, one in zip(found, measured, strict=True)]


def _priors(found: Misfit) -> dict[str, Array]:
    """Correlations (B Z, B Z) of heats that are smooth in place: steady or smooth in time, always or while driving."""
    near, drive = found.blocks.alike(), (found.blocks.phase == "drive").astype(float)
    in_time = (np.ones_like(near), np.outer(drive, drive), near, near * np.outer(drive, drive))
    return {name: np.kron(time, alike(found.zones)) for name, time in zip(HEATS, in_time, strict=True)}


def _measured(found: Misfit) -> Measured:
    trial, at_s = found.trial, found.blocks.bin_at_s
    known = np.diag(found.variance)
    for channel in trial.floating:
        rows = np.flatnonzero(found.channel == channel)
        known[np.ix_(rows, rows)] += ZERO_UM**2
    every = np.arange(len(found.y))
    causes = {name: Cause(every, found.A @ prior @ found.A.T) for name, prior in _priors(found).items()}
    names = trial.rig.names
    heat = np.flatnonzero(np.isin(found.channel, [names.index(name) for name in trial.rig.thermometers]))
    near = np.exp(-np.abs(at_s[:, None] - at_s) / ALIKE_S)
    if len(np.unique(found.channel[heat])) > 2:
        causes[ALL] = Cause(heat, near[np.ix_(found.bin[heat], found.bin[heat])])
    step = moved(found)
    for channel in np.unique(found.channel):
        rows = np.flatnonzero(found.channel == channel)
        bins = found.bin[rows]
        causes[f"drift {names[channel]}"] = Cause(rows, near[np.ix_(bins, bins)])
        causes[f"offset {names[channel]}"] = Cause(rows, np.outer(step[bins], step[bins]))
    return Measured(found.y, known, causes)


def moved(found: Misfit) -> Array:
    """Share of each bin that lies after the first motion, (bins,); 1 in a run without any."""
    after = found.trial.drive.inputs.motion.moved[1:, 0]
    after = after if after.any() else np.ones_like(after)
    return np.asarray(np.bincount(found.blocks.bin_of_tick, after) / np.bincount(found.blocks.bin_of_tick))


def _answer(found: Misfit, measured: Measured, sizes: Mapping[str, float]) -> MissingHeat:
    now = solved(measured, sizes)
    prior = np.sum([sizes[name] ** 2 * one for name, one in _priors(found).items()], axis=0)
    seen = found.A @ prior
    mean = (seen.T @ now.pull).reshape(len(found.blocks), len(found.zones))
    covariance = prior - seen.T @ now.inverse @ seen
    names = found.trial.rig.names
    readings = {}
    for channel in np.unique(found.channel):
        own = [measured.causes[f"{kind} {names[channel]}"] for kind in ("drift", "offset")]
        both = sum(
            sizes[f"{kind} {names[channel]}"] ** 2 * cause.covariance
            for kind, cause in zip(("drift", "offset"), own, strict=True)
        )
        readings[names[channel]] = _error(found, own[0].rows, np.asarray(both), now)
    if ALL in measured.causes:
        cause = measured.causes[ALL]
        readings[ALL] = _error(found, cause.rows, sizes[ALL] ** 2 * cause.covariance, now)
    return MissingHeat(found, mean, covariance, readings, sizes)


def _error(found: Misfit, rows: Array, covariance: Array, now: Solved) -> ReadingError:
    """A reading's error averaged over blocks, from its covariance (r, r) over the averages in which it shows."""
    block = found.blocks.block_of_bin[found.bin[rows]]
    ticks = np.bincount(found.blocks.bin_of_tick)[found.bin[rows]]
    blocks, of_row = np.unique(block, return_inverse=True)
    mean = np.zeros((len(blocks), len(rows)))
    mean[of_row, np.arange(len(rows))] = ticks
    mean /= mean.sum(axis=1, keepdims=True)
    seen = mean @ covariance
    left = seen @ mean.T - seen @ now.inverse[np.ix_(rows, rows)] @ seen.T
    return ReadingError(blocks, seen @ now.pull[rows], left)
