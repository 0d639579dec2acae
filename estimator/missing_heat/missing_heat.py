"""The heat that would repair the open-loop run of a recording: where, when, how much, and how sure.

    y = A h + errors of the readings + scatter

h   W/m in each zone and block of time: unknown and smooth in place; the sum of four, each of a size that the
    recordings tell, a long one part by part: steady, and smooth in time, at all times, and while driving
e   of each reading: a constant from the first motion on, seconds of lag, and something that wanders within 20
    minutes; lag and wandering also of all thermometers together; each of a size that is told likewise

All are Gaussian, so that the answer is exact given the sizes. One bad thermometer moves alone and at once; heat moves
its neighbours too, late, and the elongation: so the two are told apart, and both are kept.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.missing_heat.blocks import Blocks
from estimator.missing_heat.causes import Averages, Cause, Inverted, inverted, most_likely
from estimator.missing_heat.misfit import Misfit
from estimator.missing_heat.zones import Zone, alike
from estimator.record import Array
from estimator.work import Workers

HEATS = ("heat", "heat while driving", "changing heat", "changing heat while driving")
ALL = "thermometers"  # an error that they share
FIRST_W_M, LEAST_W_M = 5.0, 1e-3
KINDS = ("drift", "offset", "lag")
DRIFT_S = 1200.0  # a reading that drifts stays alike for so long, however soon the rig forgets
FIRST = {"drift": 0.01, "offset": 0.01, "lag": 1.0}  # K, K, s; of a length in 5 um
LEAST = {"drift": 0.01, "offset": 0.01, "lag": 0.01}
PER_K = 5.0  # um that stand for 1 K
ZERO_UM = 100.0  # sd of a zero that has no meaning


@dataclass(frozen=True)
class ReadingError:
    """What a reading shows beside the truth, over the bins in which it was read: mean (b,), covariance (b, b).

    Where its zero has no meaning the error is that of its changes, zero on the mean.
    """

    bins: Array
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


def missing_heat(found: Sequence[Misfit], workers: Workers = map) -> list[MissingHeat]:
    """The missing heat of some recordings of one rig and model."""
    measured = [_measured(part) for each in found for part in each.parts()]
    rig = found[0].trial.rig
    first, least = dict.fromkeys(HEATS, FIRST_W_M), dict.fromkeys(HEATS, LEAST_W_M)
    for name in {name for each in measured for name in each.causes} - {*HEATS}:
        kind, _, channel = name.partition(" ")
        unit = 1.0 if channel in (ALL, *rig.thermometers) else PER_K
        first[name], least[name] = FIRST[kind] * unit, LEAST[kind] * unit
    sizes = most_likely(measured, first, least, workers)
    return [_answer(each, sizes) for each in found]


def _priors(found: Misfit) -> dict[str, Array]:
    """Correlations (B Z, B Z) of heats that are smooth in place: steady or smooth in time, always or while driving."""
    near, drive = found.blocks.alike(), (found.blocks.phase == "drive").astype(float)
    in_time = (np.ones_like(near), np.outer(drive, drive), near, near * np.outer(drive, drive))
    return {name: np.kron(time, alike(found.zones)) for name, time in zip(HEATS, in_time, strict=True)}


def _measured(found: Misfit) -> Averages:
    heats = {name: found.A @ prior @ found.A.T for name, prior in _priors(found).items()}
    causes = {name: Cause(np.arange(len(found.y)), covariance) for name, covariance in heats.items()}
    return Averages(found.y, _scatter(found), causes | _readings(found))


def _scatter(found: Misfit) -> Array:
    """Covariance (N, N) of what has no size to be found: scatter, and zeros that have no meaning."""
    known = np.diag(found.variance)
    for channel in found.trial.floating:
        rows = np.flatnonzero(found.channel == channel)
        known[np.ix_(rows, rows)] += ZERO_UM**2
    return known


def _readings(found: Misfit) -> dict[str, Cause]:
    """Errors of the readings, of all thermometers together first."""
    causes = dict[str, Cause]()
    names, heat = found.trial.rig.names, found.trial.rig.is_thermometer
    together = np.flatnonzero(heat[found.channel])
    if len(np.unique(found.channel[together])) > 2:
        causes |= _errors(found, ALL, together, ("drift", "lag"))
    for channel in np.unique(found.channel):
        kinds = KINDS if heat[channel] else KINDS[:2]
        causes |= _errors(found, names[channel], np.flatnonzero(found.channel == channel), kinds)
    return causes


def _errors(found: Misfit, name: str, rows: Array, kinds: Sequence[str]) -> dict[str, Cause]:
    """Errors of these kinds that the averages `rows` share."""
    bins = found.bin[rows]
    at_s = found.blocks.bin_at_s[bins]
    shapes = {"offset": moved(found)[bins], "lag": -found.rate[rows]}
    wander = np.exp(-np.abs(at_s[:, None] - at_s) / DRIFT_S)
    covariances = {kind: wander if kind == "drift" else np.outer(shapes[kind], shapes[kind]) for kind in kinds}
    return {f"{kind} {name}": Cause(rows, covariance) for kind, covariance in covariances.items()}


def moved(found: Misfit) -> Array:
    """Share of each bin that lies after the first motion, (bins,); 1 in a run without any."""
    after = found.trial.drive.inputs.motion.moved[1:, 0]
    after = after if after.any() else np.ones_like(after)
    return found.blocks.bin_mean(after)


def _answer(found: Misfit, sizes: Mapping[str, float]) -> MissingHeat:
    prior = np.sum([sizes[name] ** 2 * one for name, one in _priors(found).items()], axis=0)
    seen = found.A @ prior
    causes = _readings(found)
    now = inverted(Averages(found.y, _scatter(found) + seen @ found.A.T, causes), sizes)
    mean = (seen.T @ now.pull).reshape(len(found.blocks), len(found.zones))
    covariance = prior - seen.T @ now.inverse @ seen
    readings = {name: _error(found, name, causes, sizes, now) for name in (*found.trial.rig.names, ALL)}
    return MissingHeat(found, mean, covariance, {n: error for n, error in readings.items() if error is not None}, sizes)


def _error(
    found: Misfit, name: str, causes: Mapping[str, Cause], sizes: Mapping[str, float], now: Inverted
) -> ReadingError | None:  # fmt: skip
    """A reading's error in each bin, of all kinds together; None where it was not read."""
    own = {cause: causes[cause] for kind in KINDS if (cause := f"{kind} {name}") in causes}
    if not own:
        return None
    rows = next(iter(own.values())).rows
    bins, of_row = np.unique(found.bin[rows], return_inverse=True)
    mean = np.zeros((len(bins), len(rows)))
    mean[of_row, np.arange(len(rows))] = 1.0
    mean /= mean.sum(axis=1, keepdims=True)
    if np.isin(found.channel[rows], found.trial.floating).all():
        ticks = found.blocks.ticks[found.bin[rows]]
        mean -= ticks / ticks.sum()
    seen = np.zeros((len(bins), len(found.y)))
    seen[:, rows] = sum(sizes[cause] ** 2 * (mean @ part.covariance) for cause, part in own.items())
    left = seen[:, rows] @ mean.T - seen @ now.inverse @ seen.T
    return ReadingError(bins, seen @ now.pull, left)
