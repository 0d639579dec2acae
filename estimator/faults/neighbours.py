"""Thermometers that leave model and neighbours slowly, while the filter follows them.

    c      by how much reading less model alone has changed within a minute to an hour, means over 30 s
    r      what neither doubtful parameters nor the other thermometers explain of it, with its sd (outlier.py)

What may drift is believed all the same, and compared with what it read when the earliest of the windows began in which
it was found, until a model that is as good as it says explains that again.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from estimator.faults.fault import Seen
from estimator.faults.machine import Known, Machine
from estimator.faults.outlier import AS_IT_IS, USUAL, WINDOWS, Departure, Means, Windows
from estimator.record import Array
from estimator.rig import Rig

BLOCK_S = 10.0
MEAN = 3  # blocks in a mean
IN_A_ROW = 3  # blocks at whose end the same one has to fail
AS_FAR = 0.3  # of the other: as far as that


@dataclass
class Block:
    """Sums over the ticks of a block, (m, ...)."""

    ticks: int = 0
    difference: Array | float = 0.0
    alone: Array | float = 0.0
    doubt: Array | float = 0.0


@dataclass(frozen=True)
class Added:
    """How many ticks were taken, which channel drifts with the last of them, and whether lengths are apart with it.

    off_share  (ticks,) by which share of their values the model's parameters are off
    shift_mm   (ticks,) by how much the nut's heat stands elsewhere than the position says
    """

    ticks: int
    drifting: int | None
    off_share: Array
    shift_mm: Array
    apart: bool = False


class Neighbours:
    """What thermometers along the screw have read in the last hour, and which of them has been failing.

    departed_K  how far the one found last had departed from the others
    may_drift_K, since_s  (m,) how far those have that are suspected, 0: the others, and since when, NaN
    """

    def __init__(self, x_mm: Array, noise: Array, heat: Array, tick_s: float, known: Known) -> None:
        """Of channels (m,): places along the screw, NaN: no neighbours; sd of a reading; which are thermometers."""
        m, self._length = len(x_mm), max(1, round(BLOCK_S / tick_s))
        self._windows = Windows(x_mm, noise**2 / (MEAN * self._length), known)
        self._machine, self._heat, self._tick_s = Machine(known, heat, tick_s), heat, tick_s
        self._last: deque[tuple[Array, Array]] = deque(maxlen=MEAN)
        self._past: deque[Means] = deque(maxlen=WINDOWS[-1] + 1)
        self._alone, self._rough_K = np.full(m, np.nan), np.zeros(m)  # of the last block; so far
        self._failed, self._times, self.departed_K = -1, 0, 0.0
        self.may_drift_K, self.since_s, self._blocks = np.zeros(m), np.full(m, np.nan), 0
        self._before: dict[int, Means] = {}  # those began to depart that are suspected
        self._block, self._astray = Block(), False

    def add(self, seen: Seen, used: Array) -> Added:
        """Take ticks up to the first at which a channel is found to drift, or may drift, or no longer, or lengths part,
        or heat is found to stand elsewhere, or no longer.

        used  (K, m) which readings are believed
        """
        k, K, block = 0, len(seen.time_s), self._block
        asked, (share, shift_mm) = used & self._heat, np.empty((2, K))
        while k < K:
            some = slice(k, min(k + self._length - block.ticks, K))
            machine = self._machine
            gone = self._windows.known.apart(seen.led[some], machine.share, machine.place_mm) & ~seen.astray[some]
            apart = bool(gone.any())
            some = slice(k, k + int(np.argmax(gone)) + 1) if apart else some
            block.difference += np.where(asked[some], seen.reading[some] - seen.alone[some], np.nan).sum(axis=0)
            block.alone += seen.alone[some].sum(axis=0)
            block.doubt += seen.doubt[some].sum(axis=0)
            self._machine.hear(seen, some, used[some])
            self._astray |= bool(seen.astray[some].any())
            share[some], shift_mm[some] = self._machine.share, self._machine.shift_mm
            block.ticks, k = block.ticks + some.stop - some.start, some.stop
            found, before = None, (self.elsewhere, *self.may_drift_K)
            if block.ticks == self._length:
                found = self._close(block, float(seen.time_s[k - 1]))
                share[k - 1], shift_mm[k - 1] = self._machine.share, self._machine.shift_mm
                block = self._block
            if found is not None or apart or not np.array_equal(before, (self.elsewhere, *self.may_drift_K)):
                return Added(k, found, share[:k], shift_mm[:k], apart)
        return Added(K, None, share, shift_mm)

    @property
    def elsewhere(self) -> bool:
        """Whether the nut's heat stands elsewhere than the position says."""
        return self._machine.shift_mm != 0.0

    def forget(self, i: int) -> None:
        """Channel i has another zero from now on."""
        means = [*self._past, *self._before.values()]
        for difference in [each.difference for each in means] + [block[0] for block in self._last]:
            difference[i] = np.nan
        self._block.difference = np.where(np.arange(len(self._alone)) == i, np.nan, self._block.difference)
        self._machine.forget(i)
        self._trust(i)

    def forget_all(self, known: Known) -> None:
        """What has been seen says nothing any more: the model is another one, of which other parameters are known."""
        if not np.array_equal(known.whole, self._windows.known.whole):
            self._machine = Machine(known, self._heat, self._tick_s)
        self._windows.known = known
        self._past.clear()
        self._last.clear()
        self._block = Block()
        for i in list(self._before):
            self._trust(i)

    def _close(self, block: Block, now_s: float) -> int | None:
        """The end of a block: which channel has failed often enough."""
        self._machine.block(block.ticks)
        self._windows.share, self._windows.place_mm = self._machine.share, self._machine.place_mm
        if self._astray or self.elsewhere:
            self._astray = False
            self.forget_all(self._windows.known)
            return None
        alone = np.asarray(block.alone / block.ticks)
        self._rough_K = self._rough_K + self._windows.rough(alone - self._alone)
        self._last.append((np.asarray(block.difference / block.ticks), np.asarray(block.doubt / block.ticks)))
        self._alone, self._block = alone, Block()
        if len(self._last) < MEAN:
            return None
        difference, doubt = (np.mean(each, axis=0) for each in zip(*self._last, strict=True))
        self._blocks += 1
        self._past.append(Means(self._blocks, difference, doubt, self._rough_K))
        nobody = Departure(self._past[-1], -1, 0.0, 0.0, 0.0)
        departed = [nobody, *self._windows.departures(self._past)]
        self._suspect(max(departed, key=lambda one: one.may_drift), now_s)
        worst = max(departed, key=lambda one: one.drifts)
        failed = worst.channel if worst.drifts > 1.0 else -1
        self._times = self._times + 1 if failed >= 0 and failed == self._failed else 1
        self._failed, self.departed_K = failed, max(worst.off_K, abs(self.may_drift_K[failed]))
        return failed if failed >= 0 and self._times >= IN_A_ROW else None

    def _suspect(self, worst: Departure, now_s: float) -> None:
        """One is suspected, anew or still; suspicions of what is explained again pass."""
        if worst.may_drift > 1.0:
            i = worst.channel
            self._before[i] = min(self._before.get(i, worst.before), worst.before, key=lambda means: means.block)
            self.since_s[i] = np.fmin(self.since_s[i], now_s)
        for i, before in list(self._before.items()):
            change, at = self._windows.change(before, self._past[-1])
            if i in at:
                tested = change.tested(i, at, AS_IT_IS)
                self.may_drift_K[i] = tested.value
                if abs(tested.value) <= USUAL * tested.sd:
                    self._trust(i)

    def _trust(self, i: int) -> None:
        """Channel i is no longer suspected."""
        self._before.pop(i, None)
        self.may_drift_K[i], self.since_s[i] = 0.0, np.nan


def may_be_heat(side: Array, rig: Rig) -> Array:
    """Which of the thermometers that drift may be right, where a whole recording is at hand: (m,) bool.

    side  (m,) how far each has, over time, 0: it does not

    Heat moves the next thermometer too; beyond the last one there is none that could tell. Two that move as far as each
    other to opposite sides are swapped.
    """
    found = np.zeros(len(side), dtype=bool)
    places = [(rig.channels[name].at_mm, rig.index(name)) for name in rig.thermometers]
    order = np.array([i for at_mm, i in sorted((at, i) for at, i in places if at is not None)], dtype=int)
    if len(order) < 2:
        return found
    own = side[order]
    beside = np.array([np.append(0.0, own[:-1]), np.append(own[1:], 0.0)])
    sizes = np.abs([beside, np.broadcast_to(own, beside.shape)])
    swapped = ((beside * own < 0) & (sizes.min(axis=0) > AS_FAR * sizes.max(axis=0))).any(axis=0)
    is_last = np.isin(np.arange(len(own)), (0, len(own) - 1))
    found[order] = (own != 0) & ~swapped & ((beside != 0).any(axis=0) | is_last)
    return found
