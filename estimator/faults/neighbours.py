"""Thermometers that leave model and neighbours slowly, while the filter follows them.

    c      by how much reading less model alone has changed within one to ten minutes, means over 30 s
    r      what neither doubtful parameters nor the other thermometers explain of it, with its sd (outlier.py)
    limit  (7 + 4 ln s) sd + 0.4 s rough + 8 beside
    s      how many times worse the model is than it says, forgotten within minutes
    rough  how much the model alone has gone up and down in that time beside what its neighbours say of it: where that
           is rough, a model that is wrong is rough too
    beside what the next thermometers leave unexplained beyond 2 sd, found without this one; forgotten within minutes:
           heat that the model lacks moves them too

The one that is off by most sd is tested, by those that are left without the next one: two that fail together do not
hide each other.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from estimator.faults.fault import Seen
from estimator.faults.outlier import SCALES, Unexplained, unexplained
from estimator.record import Array

BLOCK_S = 10.0
MEAN = 3  # blocks in a mean
WINDOWS = (6, 14, 32, 62)  # blocks
ALIKE_MM, COMMON_K, SMOOTH_K, SINGLE_K = 250.0, 5.0, 0.01, 0.003  # of c along the screw; the last two in two minutes
TWO_MINUTES = 12  # blocks
SURE, WORSE, ROUGH, BESIDE, USUAL = 7.0, 4.0, 0.4, 8.0, 2.0
KEPT, KEPT_SCALE = 0.9, 0.95  # of what the last block has shown
IN_A_ROW = 3  # blocks at whose end the same one has to fail
FEWEST = 5  # thermometers, of which one can be told from the others
ROUGH_SINGLE_K = 0.05  # of what the model alone changes by, beside 1 K that is alike along the screw
AS_IT_IS = np.ones(1)  # the scale of a model that is as good as it says
NOBODY = -1, 0.0, 1.0


@dataclass
class Block:
    """Sums over the ticks of a block, (m, ...)."""

    ticks: int = 0
    difference: Array | float = 0.0
    alone: Array | float = 0.0
    doubt: Array | float = 0.0


@dataclass(frozen=True)
class Means:
    """Over some blocks, (m, ...): reading less model alone, how that moves with doubts; how rough the model has been up
    to then."""

    difference: Array
    doubt: Array
    rough: Array


@dataclass(frozen=True)
class Change:
    """Of reading less model alone over a window, (m,) K, with what explains it, (m, m); and rough (m,) K."""

    value: Array
    model: Array
    scatter: Array
    rough: Array

    def of(self, some: Array, scales: Array) -> Unexplained:
        """What some of them leave of each other unexplained."""
        both = np.ix_(some, some)
        return unexplained(self.value[some], self.model[both], self.scatter[both], scales)


class Neighbours:
    """What thermometers along the screw have read in the last ten minutes, and which of them has been failing.

    departed_K  how far the one found last had departed from the others
    """

    def __init__(self, x_mm: Array, noise: Array, tick_s: float) -> None:
        """x_mm (m,) places along the screw, NaN: a channel without neighbours; noise (m,) sd of each reading."""
        self._x, self._length = x_mm, max(1, round(BLOCK_S / tick_s))
        self._scatter = COMMON_K**2 + np.diag(2.0 * noise**2 / (MEAN * self._length))
        self._alike = np.exp(-0.5 * ((x_mm[:, None] - x_mm) / ALIKE_MM) ** 2)
        self._last: deque[tuple[Array, Array]] = deque(maxlen=MEAN)
        self._past: deque[Means] = deque(maxlen=WINDOWS[-1] + 1)
        self._alone, self._rough_K = np.full(len(x_mm), np.nan), np.zeros(len(x_mm))  # of the last block; so far
        self._beside = np.zeros((len(WINDOWS), len(x_mm)))
        self._scale = np.ones(len(WINDOWS))
        self._failed, self._times, self.departed_K = -1, 0, 0.0
        self._block = Block()

    def add(self, seen: Seen, asked: Array) -> tuple[int, int | None]:
        """Take ticks up to the first at which a channel is found to drift: how many were taken, and which one it is.

        asked  (m,) which channels are to be compared
        """
        k, K, block = 0, len(seen.time_s), self._block
        while k < K:
            some = slice(k, min(k + self._length - block.ticks, K))
            block.difference += np.where(asked, seen.reading[some] - seen.alone[some], np.nan).sum(axis=0)
            block.alone += seen.alone[some].sum(axis=0)
            block.doubt += seen.doubt[some].sum(axis=0)
            block.ticks, k = block.ticks + some.stop - some.start, some.stop
            if block.ticks == self._length:
                if (found := self._close(block)) is not None:
                    return k, found
                block = self._block
        return K, None

    def forget(self, i: int) -> None:
        """Channel i has another zero from now on."""
        for difference in [means.difference for means in self._past] + [block[0] for block in self._last]:
            difference[i] = np.nan
        self._block.difference = np.where(np.arange(len(self._x)) == i, np.nan, self._block.difference)

    def forget_all(self) -> None:
        """What has been seen says nothing any more: the model is another one."""
        self._past.clear()
        self._last.clear()
        self._block = Block()

    def _close(self, block: Block) -> int | None:
        """The end of a block: which channel has failed often enough."""
        alone = np.asarray(block.alone / block.ticks)
        self._rough_K = self._rough_K + self._rough(alone - self._alone)
        self._last.append((np.asarray(block.difference / block.ticks), np.asarray(block.doubt / block.ticks)))
        self._alone, self._block = alone, Block()
        if len(self._last) < MEAN:
            return None
        difference, doubt = (np.mean(each, axis=0) for each in zip(*self._last, strict=True))
        self._past.append(Means(difference, doubt, self._rough_K))
        worst = self._worst()
        self._times = self._times + 1 if worst >= 0 and worst == self._failed else 1
        self._failed = worst
        return worst if worst >= 0 and self._times >= IN_A_ROW else None

    def _rough(self, change: Array) -> Array:
        """How far the model alone has changed beside what it says of the neighbours, (m,) K."""
        rough, at = np.zeros(len(change)), np.flatnonzero(np.isfinite(self._x + change))
        if len(at):
            own = COMMON_K**2 + ROUGH_SINGLE_K**2 * np.eye(len(at))
            rough[at] = np.abs(unexplained(change[at], self._alike[np.ix_(at, at)], own, AS_IT_IS).value)
        return rough

    def _worst(self) -> int:
        """The channel that is furthest beyond its limit over any of the windows, -1: none."""
        worst, most = -1, 1.0
        self._beside *= KEPT
        self._scale = np.maximum(1.0, KEPT_SCALE * self._scale)
        for w, blocks in enumerate(WINDOWS):
            if len(self._past) > blocks:
                i, off, limit = self._departed(w, blocks)
                if off > most * limit:
                    worst, most, self.departed_K = i, off / limit, off
        return worst

    def _departed(self, w: int, blocks: int) -> tuple[int, float, float]:
        """The thermometer that is off by most sd over a window, by how much, and its limit; 0 of 1: none may be."""
        change = self._change(blocks)
        at = np.flatnonzero(np.isfinite(change.value) & np.isfinite(self._x))
        if len(at) < FEWEST:
            return NOBODY
        first = change.of(at, AS_IT_IS)
        if (np.abs(first.value) <= SURE * first.sd + ROUGH * change.rough[at]).all():
            return NOBODY
        scales = np.maximum(SCALES, self._scale[w])
        i = int(at[change.of(at, scales).furthest])
        rest = at[at != i]
        others = change.of(rest, scales)
        self._beside[w, i] = max(self._beside[w, i], self._beyond_usual(i, rest, others))
        tested = change.of(np.append(np.delete(rest, others.furthest), i), scales)
        scale = self._scale[w] = tested.scale[-1]
        limit = (SURE + WORSE * np.log(scale)) * tested.sd[-1] + ROUGH * scale * change.rough[i]
        return i, float(abs(tested.value[-1])), float(limit + BESIDE * self._beside[w, i])

    def _change(self, blocks: int) -> Change:
        """From so many blocks ago to now."""
        past, now = self._past[-1 - blocks], self._past[-1]
        moved, unknown = now.doubt - past.doubt, SMOOTH_K**2 * self._alike + SINGLE_K**2 * np.eye(len(self._x))
        model = moved @ moved.T + blocks / TWO_MINUTES * unknown
        return Change(now.difference - past.difference, model, self._scatter, now.rough - past.rough)

    def _beyond_usual(self, i: int, rest: Array, others: Unexplained) -> float:
        """What the next thermometers to both sides leave unexplained beyond what is usual."""
        beyond = np.maximum(np.abs(others.value) - USUAL * others.sd, 0.0)
        away = self._x[rest] - self._x[i]
        sides = [np.where(side * away > 0, side * away, np.inf) for side in (-1, 1)]
        return max(float(beyond[np.argmin(side)]) for side in sides if np.isfinite(side).any())
