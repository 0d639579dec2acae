"""Readings that leave the model suddenly: further than their own scatter and the model's uncertainty explain.

    deviation   innovation - level            level: the innovation's mean over the last 8 ticks
    limit       6.5 scatter + 0.27 (moved + |level|), no less than 3 sd of what the model takes for a reading's noise
    scatter     sd of a reading by the differences of successive innovations, larger where their predicted sd is; no
                less than its resolution makes, step / sqrt(12): what reads the same for minutes has a scatter too
    moved       |by what the model alone has left its own mean of the last 16 s|

The level takes what a model has always been wrong by; what has moved, what it may have become wrong by since. After a
silence the limit is 10 sd of what is expected, the same share of what the model alone has moved by meanwhile, and what
heat that the model lacks may have done; but where none was seen before, the next thermometers must show it too.
"""

from dataclasses import dataclass

import numpy as np

from estimator.faults.fault import Seen
from estimator.record import Array, held

LEVEL_TICKS = 8  # over which a level is learnt
SCATTER = 4.0  # so many times as long: its scatter
MOVED_S = 16.0  # and over which the model alone is looked back upon
LENGTHS = 4  # readings over which that of a length is: one comes with each stroke
SCATTERS, SHARE = 6.5, 0.27
ALLOWED = 3.0  # sd of noise: where it stands for what a model lacks, readings are off by as much for long
SUDDEN = 0.7  # of the limit, from the last reading that was well: less is no jump, but a model that is wrong
ASTRAY = 3.0  # times the limit, while heat is in the wrong place
OUTLYING = 3.0  # a scatter so many times that of the median thermometer is no scatter any more
MEANS = [0, 1, 4, 6]  # of what is known of a channel: level, scatter^2, sd, mean of the model alone
UNKNOWN_SD = 10.0  # the limit where no level is known; and after a silence, in which the model may have gone astray
HEAT_K, HEAT_S = 3.0, 900.0  # by as much in that time: 10 W that the model lacks; what lasts comes no further
SPREAD = 3.0  # times what one of the next thermometers shows of it


@dataclass(frozen=True)
class Deviations:
    """Of K ticks, (K, m): deviation, limit, whether it is beyond that, stress; what is learnt with each, (K, 9, m)."""

    value: Array
    limit: Array
    beyond: Array
    count: Array
    trail: Array


class Jumps:
    """What is known of each channel's innovation, learnt from those that are well."""

    def __init__(self, noise: Array, heat: Array, tick_s: float, x_mm: Array) -> None:
        """noise (m,) sd of a reading, inf: no model; heat (m,) bool, which channels are thermometers; x_mm (m,) their
        places, NaN: beside the screw."""
        self._modelled, self._heat = np.isfinite(noise), heat
        self._noise = noise = np.where(self._modelled, noise, 1.0)
        self._ticks = np.where(heat, LEVEL_TICKS, LENGTHS)
        self._nearest = _nearest(x_mm)
        self._back = 1.0 / max(LEVEL_TICKS, MOVED_S / tick_s)
        # rows: level, scatter^2, last value, count of readings, sd; read at the last tick, mean of the model alone; the
        # model alone at the last reading whose level was known, and when that was
        self._unknown = np.array([0.0 * heat, noise**2, np.nan * heat, 0.0 * heat, noise])
        self._state = np.vstack([self._unknown, 1.0 * heat, *np.full((3, len(heat)), np.nan)])

    @property
    def known(self) -> Array:
        """Which levels are known, (m,) bool."""
        return np.asarray(self._state[3] >= self._ticks)

    def compare(self, seen: Seen, well: Array, warm: Array, resolution: Array) -> Deviations:
        """Readings against levels as they would be learnt at each tick, of channels that are well (m,); none is yet.

        warm  (m,) bool, where there is heat that the model lacks already;   resolution  of readings, (K, m)
        """
        trail = self._learnt(seen, well)
        level, variance, last, count, usual_sd, read, path, *before = trail[:-1].transpose(1, 0, 2)
        scatter = np.sqrt(variance)
        usual = np.median(scatter[:, self._heat], axis=1)[:, None] if self._heat.any() else np.inf
        scatter = np.where(self._heat, np.minimum(scatter, OUTLYING * usual), scatter)
        scatter = np.maximum(scatter, resolution / np.sqrt(12.0))
        moved = np.nan_to_num(np.abs(seen.alone - path))
        known = count >= self._ticks
        sd = np.where(np.isfinite(seen.sd), seen.sd, 0.0)
        off = np.append(np.nan_to_num(np.abs(seen.value)), np.zeros((len(seen.value), 1)), axis=1)
        shown = np.where(warm, np.inf, SPREAD * off[:, self._nearest].max(axis=2))
        unknown = UNKNOWN_SD * seen.sd + np.where(self._heat, np.minimum(_silent(seen, warm, *before), shown), 0.0)
        limit = np.where(
            known,
            SCATTERS * scatter * np.maximum(sd / usual_sd, 1.0) + SHARE * (moved + np.abs(level)),
            unknown,
        )
        limit = np.maximum(limit, np.where(self._heat, ALLOWED * self._noise, 0.0))
        limit = np.where(self._heat & (read == 0.0), np.maximum(limit, unknown), limit)
        limit = np.where(seen.astray[:, None], ASTRAY * limit, limit)
        value = seen.value - np.where(known, level, 0.0)
        sudden = np.isnan(last) | (np.abs(seen.value - last) > SUDDEN * limit)
        return Deviations(value, limit, (np.abs(value) > limit) & sudden, count, trail[1:])

    def _learnt(self, seen: Seen, well: Array) -> Array:
        """State before and after each of the ticks, (K + 1, 9, m)."""
        now = np.isfinite(seen.value) & self._modelled & well
        trail = np.empty((len(now) + 1, *self._state.shape))
        trail[0] = self._state
        trail[1:, 3] = self._state[3] + np.cumsum(now, axis=0)
        trail[1:, 5] = np.isfinite(seen.value)
        for row, each in ((7, seen.alone), (8, np.broadcast_to(seen.time_s[:, None], now.shape))):
            trail[:, row] = held(
                np.where((trail[1:, 5] > 0) & (trail[1:, 3] >= self._ticks), each, np.nan), self._state[row]
            )
        trail[:, 2] = last = held(np.where(now, seen.value, np.nan), self._state[2])
        gain = np.where(now, 1.0 / np.minimum(trail[:-1, 3] + 1.0, self._ticks), 0.0)
        difference = np.where(now & np.isfinite(last[:-1]), seen.value - last[:-1], 0.0)
        slow = np.where(difference == 0.0, 0.0, 1.0 / (SCATTER * self._ticks))
        gains = np.stack([gain, slow, gain, np.full_like(gain, self._back)], axis=1)
        value, sd = (np.where(now, each, 0.0) for each in (seen.value, seen.sd))
        towards = np.stack([value, difference**2 / 2.0, sd, seen.alone], axis=1)
        mean = self._state[MEANS]
        mean[-1] = np.where(np.isfinite(mean[-1]), mean[-1], seen.alone[0])
        for k in range(len(now)):
            mean = towards[k] = mean + gains[k] * (towards[k] - mean)
        trail[1:, MEANS] = towards
        return trail

    def learn(self, deviations: Deviations, k: int, well: Array) -> None:
        """Take the first k ticks; of channels that are not well (m,) only where the model alone has been."""
        learnt = deviations.trail[k - 1]
        self._state[:5] = np.where(well, learnt[:5], self._state[:5])
        self._state[5:] = learnt[5:]

    def forget(self, which: Array) -> None:
        """Learn the levels of these channels (m,) anew."""
        self._state[:5, which] = self._unknown[:, which]


def _silent(seen: Seen, warm: Array, alone: Array, time_s: Array) -> Array:
    """How far the model may be wrong since the last readings, (K, m) K, when it alone was at `alone`; 0: before any."""
    share = np.where(warm, 1.0, np.minimum((seen.time_s[:, None] - time_s) / HEAT_S, 1.0))
    return np.nan_to_num(SHARE * np.abs(seen.alone - alone) + HEAT_K * share)


def _nearest(x_mm: Array) -> Array:
    """The next thermometers to both sides of each, (m, 2); m: none."""
    away = x_mm - x_mm[:, None]
    sides = np.stack([np.where(side * away > 0, side * away, np.inf) for side in (-1, 1)], axis=1)
    return np.where(np.isfinite(sides.min(axis=2)), np.argmin(sides, axis=2), len(x_mm))
