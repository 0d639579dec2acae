"""Thermometers that leave their neighbours slowly, while model and filter follow them.

    d      reading less model alone, mean over 30 s;    c  by how much d has changed within 2, 5 or 10 minutes
    r      c less what the other thermometers' c say of it, by a Gaussian process along the screw
    limit  floor + 1.3 rough + 7 others
    rough  how much the model alone has gone up and down in that time beside what its neighbours say of it: where that
           is rough, a model that is wrong is rough too
    others the 0.8 quantile of the other thermometers' |r|, found without this one; forgotten within minutes

r of all is inverse(C) c over the diagonal of inverse(C) (Rasmussen and Williams 2006, 5.12). The one that is off by
most sd is tested, by those that are left without the next one: two that fail together do not hide each other.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from estimator.faults.fault import Seen
from estimator.record import Array

BLOCK_S = 10.0
MEAN = 3  # blocks in a mean
WINDOWS = ((14, 0.04), (32, 0.053), (62, 0.067))  # blocks, and the floor of each in K
ALIKE_MM, COMMON_K, SMOOTH_K, SINGLE_K = 250.0, 5.0, 1.0, 0.05  # of c along the screw
OTHERS, QUANTILE, KEPT = 7.0, 0.8, 0.9
ROUGH = 1.3
IN_A_ROW = 3  # blocks at whose end the same one has to fail
FEWEST = 5  # thermometers, of which one can be told from the others


@dataclass
class Block:
    """Sums over the ticks of a block, (m,)."""

    ticks: int
    difference: Array
    alone: Array


class Neighbours:
    """What thermometers along the screw have read in the last ten minutes, and which of them has been failing.

    departed_K  how far the one found last had departed from the others
    """

    def __init__(self, x_mm: Array, tick_s: float) -> None:
        """x_mm (m,) places along the screw, NaN: a channel without neighbours."""
        self._placed, self._length = np.isfinite(x_mm), max(1, round(BLOCK_S / tick_s))
        x = np.where(self._placed, x_mm, 0.0)
        alike = np.exp(-0.5 * ((x[:, None] - x) / ALIKE_MM) ** 2)
        self._C = COMMON_K**2 + SMOOTH_K**2 * alike + SINGLE_K**2 * np.eye(len(x))
        self._past: deque[tuple[Array, Array]] = deque(maxlen=WINDOWS[-1][0] + MEAN)  # d and roughness of each block
        self._alone = np.full(len(x), np.nan)  # of the last block
        self._others = np.zeros(len(WINDOWS))
        self._failed, self._times, self.departed_K = -1, 0, 0.0
        self._block = self._empty()
        self._inverse = lru_cache(maxsize=64)(self._inverted)

    def add(self, seen: Seen, asked: Array) -> tuple[int, int | None]:
        """Take ticks up to the first at which a channel is found to drift: how many were taken, and which one it is.

        asked  (m,) which channels are to be compared
        """
        k, K, block = 0, len(seen.time_s), self._block
        while k < K:
            some = slice(k, min(k + self._length - block.ticks, K))
            block.difference += np.where(asked, seen.reading[some] - seen.alone[some], np.nan).sum(axis=0)
            block.alone += seen.alone[some].sum(axis=0)
            block.ticks, k = block.ticks + some.stop - some.start, some.stop
            if block.ticks == self._length:
                if (found := self._close(block)) is not None:
                    return k, found
                block = self._block
        return K, None

    def forget(self, i: int) -> None:
        """Channel i has another zero from now on."""
        for difference, _ in self._past:
            difference[i] = np.nan
        self._block.difference[i] = np.nan

    def _empty(self) -> Block:
        return Block(0, np.zeros(len(self._C)), np.zeros(len(self._C)))

    def _close(self, block: Block) -> int | None:
        """The end of a block: which channel has failed often enough."""
        alone = block.alone / block.ticks
        rough = np.zeros_like(alone)
        rough[self._placed] = self._left_out(alone - self._alone, np.flatnonzero(self._placed))[0]
        self._past.append((block.difference / block.ticks, np.nan_to_num(rough)))
        self._alone, self._block = alone, self._empty()
        worst = self._worst()
        self._times = self._times + 1 if worst >= 0 and worst == self._failed else 1
        self._failed = worst
        return worst if worst >= 0 and self._times >= IN_A_ROW else None

    def _worst(self) -> int:
        """The channel that is furthest beyond its limit over any of the windows, -1: none."""
        differences, rough = (np.array(each) for each in zip(*self._past))
        worst, most = -1, 1.0
        for w, (blocks, floor) in enumerate(WINDOWS):
            if len(differences) >= blocks + MEAN:
                before = differences[len(differences) - blocks - MEAN : len(differences) - blocks].mean(axis=0)
                change = differences[-MEAN:].mean(axis=0) - before
                i, off, limit = self._outlier(w, change, floor + ROUGH * rough[-blocks:].sum(axis=0))
                if off > most * limit:
                    worst, most, self.departed_K = i, off / limit, off
        return worst

    def _outlier(self, w: int, change: Array, least: Array) -> tuple[int, float, float]:
        """The channel that is off by most sd over window w, by how much, and its limit."""
        at = np.flatnonzero(np.isfinite(change) & self._placed)
        if len(at) < FEWEST:
            return -1, 0.0, 1.0
        i = self._furthest(change, at)
        rest = at[at != i]
        rest = rest[rest != self._furthest(change, rest)]
        r = self._left_out(change, np.append(rest, i))[0][-1]
        others = np.sort(self._left_out(change, rest)[0])
        self._others[w] = max(others[int(QUANTILE * len(others))], KEPT * self._others[w])
        return i, float(r), float(least[i] + OTHERS * self._others[w])

    def _furthest(self, change: Array, at: Array) -> int:
        """Of the channels `at`, the one that is off by most sd; if one is wrong, this is it."""
        r, variance = self._left_out(change, at)
        return int(at[np.argmax(r**2 / variance)])

    def _left_out(self, change: Array, at: Array) -> tuple[Array, Array]:
        """|r| of the channels `at`, and the variances of r by C."""
        inverse = self._inverse(tuple(at.tolist()))
        variance = 1.0 / np.diag(inverse)
        return np.abs(inverse @ change[at]) * variance, variance

    def _inverted(self, at: tuple[int, ...]) -> Array:
        return np.asarray(np.linalg.inv(self._C[np.ix_(at, at)]))
