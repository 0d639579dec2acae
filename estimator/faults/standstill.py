"""Readings that stand still where the sensor resolves its own noise."""

from dataclasses import dataclass

import numpy as np

from estimator.record import Array, held

STEPS = 1.5  # resolution steps from one reading of a length to the next, on average; as much noise makes thermometers
TURNED = 1.25  # go back by so many, the smaller of two changes counted: then 20 repeats do not happen by chance
CHANGES = 20  # that must have been seen
LONGER = 3.0  # times as long as ever before: a logger repeats readings
SAME = 1e-9  # of a reading, or of 1: it differs by no more than its sum or mean was rounded by, which is no change


@dataclass(frozen=True)
class Repeats:
    """Of K ticks, (K, m): how often the reading has been repeated, 0 of a coarse sensor; its resolution, 0 before any
    change; and what is learnt."""

    count: Array
    resolution: Array
    trail: tuple[Array, ...]


class Standstill:
    """How finely m channels resolve their own noise, and for how many readings each has read the same.

    The resolution is the smallest change ever seen. A coarse sensor, whose readings change by one step or not at all,
    may well stand still: of it nothing can be said. What a thermometer's own noise is shows where a change goes back
    on the one before, in the smaller of the two: a temperature may rise by many steps a tick, and then rest within
    one. A length has seldom a reading: all its changes count, and it counts as many repeats by chance are unlikely,
    n ln(mean change / resolution), and no more than its readings have stood before are so.
    """

    def __init__(self, heat: Array) -> None:
        """heat (m,) bool, which channels are thermometers."""
        m, self._heat, self._stood = len(heat), heat, np.zeros(len(heat))
        self._last, self._finest, self._changed = np.full(m, np.nan), np.full(m, np.inf), np.zeros(m)
        self._steps = np.where(heat, TURNED, STEPS)
        self._same, self._changes, self._sum = np.zeros(m), np.zeros(m), np.zeros(m)

    def compare(self, reading: Array) -> Repeats:
        """Repeats with each tick, of readings (K, m), NaN where nothing was read; nothing is learnt yet."""
        filled = held(reading, self._last)
        change = np.where(np.isfinite(reading), np.abs(np.diff(filled, axis=0)), np.nan)
        moved = change > SAME * np.maximum(np.abs(filled[1:]), 1.0)
        repeats = self._same + np.cumsum(np.isfinite(change) & ~moved, axis=0)
        same = repeats - np.maximum.accumulate(np.where(moved, repeats, 0.0), axis=0)
        before = np.vstack([self._same, same[:-1]])
        finest = np.minimum(np.minimum.accumulate(np.where(moved, change, np.inf), axis=0), self._finest)
        changed = held(np.where(moved, np.diff(filled, axis=0), np.nan), self._changed)
        scattered = moved & ((changed[1:] * changed[:-1] < 0.0) | ~self._heat)
        size = np.where(self._heat, np.minimum(change, np.abs(changed[:-1])), change)
        changes = self._changes + np.cumsum(scattered, axis=0)
        total = self._sum + np.cumsum(np.where(scattered, size, 0.0), axis=0)
        fine = (changes >= CHANGES) & (total >= self._steps * changes * np.where(changes, finest, 0.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            unlikely = np.where(fine, np.log(total / changes / finest), 0.0)
        stood = np.maximum.accumulate(np.vstack([self._stood, np.where(moved, before, 0.0)]), axis=0)[1:]
        count = np.where(self._heat, same, np.where(same > LONGER * stood, same * unlikely, 0.0))
        resolution = np.where(np.isfinite(finest), finest, 0.0)
        return Repeats(
            np.where(fine, count, 0.0), resolution, (filled[1:], finest, changed[1:], same, changes, total, stood)
        )

    def learn(self, repeats: Repeats, k: int) -> None:
        """Take the first k ticks."""
        state = (a[k - 1] for a in repeats.trail)
        self._last, self._finest, self._changed, self._same, self._changes, self._sum, self._stood = state
