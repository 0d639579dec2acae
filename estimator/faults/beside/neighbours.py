"""Thermometers that leave model and neighbours slowly, while the filter follows them.

    c      by how much reading less model alone has changed within a minute to an hour, means over 30 s
    r      what neither doubtful parameters nor the other thermometers explain of it, with its sd (change.py)

What may drift is believed all the same, and compared with what it read when the earliest of the windows began in which
it was found, until a model that is as good as it says explains that again, or the others show that it is heat which the
model lacks.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.faults.beside.change import AS_IT_IS, Change, Tested
from estimator.faults.beside.scatter import Scatter
from estimator.faults.beside.windows import BLOCK_S, USUAL, WINDOWS, Departure, Means, Windows
from estimator.faults.fault import FORGOTTEN_S, Seen
from estimator.faults.machine import Known, Machine
from estimator.record import Array
from estimator.rig import Rig

MEAN = 3  # blocks in a mean
IN_A_ROW = 3  # blocks at whose end the same one has to fail
ALIKE = 0.5  # of a departure: as far as that heat at its place does not warm the next ones
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
    lacks_K    (ticks, m) by how much channels depart by heat that the model lacks
    departs_K  (ticks, m) by how much others do, which are not suspected
    shift_mm   (ticks,) by how much the nut's heat stands elsewhere than the position says
    """

    ticks: int
    drifting: int | None
    off_share: Array
    shift_mm: Array
    lacks_K: Array
    departs_K: Array
    apart: bool = False


class Neighbours:
    """What thermometers along the screw have read in the last hour, and which of them has been failing.

    departed_K  how far the one found last had departed from the others
    heated      (m,) bool, those that have been suspected up to the last tick, and only read heat that the model lacks
    lacks_K     (m,) by how much those depart that do, or have done, 0: the others
    may_drift_K, since_s  (m,) how far those have that are suspected, 0: the others, and since when, NaN
    """

    def __init__(self, rig: Rig, noise: Array, known: Known) -> None:
        """noise (m,): sd of a reading of each channel; known: how well the model's parameters are."""
        self._heat, self._tick_s, m = rig.is_thermometer, rig.tick_s, len(noise)
        self._length = max(1, round(BLOCK_S / rig.tick_s))
        self._windows = Windows(rig.x_mm, noise**2 / (MEAN * self._length), known, rig.screw)
        self._machine = Machine(known, self._heat, rig.tick_s)
        self._noise, self._scatter = noise, Scatter(self._heat & np.isfinite(noise))
        self._last: deque[tuple[Array, Array]] = deque(maxlen=MEAN)
        self._past: deque[Means] = deque(maxlen=WINDOWS[-1] + 1)
        self._alone, self._rough_K = np.full(m, np.nan), np.zeros(m)  # of the last block; so far
        self._failed, self._times, self.departed_K = -1, 0, 0.0
        self.may_drift_K, self.since_s, self._blocks = np.zeros(m), np.full(m, np.nan), 0
        self.heated, self.lacks_K, self._lacked = np.zeros(m, dtype=bool), np.zeros(m), dict[int, Means]()
        self._warm_to = np.full(m, -1)  # the block up to which such heat may be there, or have been in any window
        self._before: dict[int, Means] = {}  # those began to depart that are suspected
        self._block, self._astray = Block(), False

    def add(self, seen: Seen, used: Array) -> Added:
        """Take ticks up to the first at which a channel is found to drift, or may drift, or no longer, or lengths part,
        or heat is found to stand elsewhere, or to be missing somewhere, or no longer.

        used  (K, m) which readings are believed
        """
        k, K, block, found, end = 0, len(seen.time_s), self._block, None, None
        told = (*np.empty((2, K)), *np.empty((2, *used.shape)))
        difference, astray = np.where(used & self._heat, seen.reading - seen.alone, np.nan), seen.astray.any()
        far, perhaps_heat = bool(seen.led.far.any()), self.may_drift_K.any() or self._windows.warm.any()
        self.heated[:] = False
        while k < K:
            some = slice(k, min(k + self._length - block.ticks, K))
            end = self._parted(seen, some) if far and not perhaps_heat else None  # of heat, lengths tell
            some = slice(k, end or some.stop)
            block.difference += difference[some].sum(axis=0)
            block.alone += seen.alone[some].sum(axis=0)
            block.doubt += seen.doubt[some].sum(axis=0)
            self._scatter.hear(difference[some])
            self._machine.hear(seen, some, used[some] & (self.may_drift_K == 0.0) & ~self._windows.furthest)
            self._astray |= bool(astray and seen.astray[some].any())
            self._tell(told, some)
            block.ticks, k, before = block.ticks + some.stop - k, some.stop, self._state
            if block.ticks == self._length:
                found = self._close(block, float(seen.time_s[k - 1]))
                self._tell(told, slice(k - 1, k))
                block = self._block
            if found is not None or end is not None or before != self._state:
                break
        share, shift_mm, lacks_K, departs_K = (rows[:k] for rows in told)
        return Added(k, found, share, shift_mm, lacks_K, departs_K, end is not None)

    def _tell(self, told: Sequence[Array], some: slice) -> None:
        """Note what is known by now for some ticks."""
        now = self._machine.share, self._machine.shift_mm, self.lacks_K, self.departs_K
        for rows, value in zip(told, now, strict=True):
            rows[some] = value

    @property
    def _state(self) -> tuple[bool, bytes, bytes]:
        """What others are told of at once when it changes."""
        return self.elsewhere, self.may_drift_K.tobytes(), self.warm.tobytes()

    def _parted(self, seen: Seen, some: slice) -> int | None:
        """The end of the first of some ticks with which lengths have led further than thermometers allow."""
        machine = self._machine
        gone = self._windows.known.apart(seen.led[some], machine.share, machine.place_mm) & ~seen.astray[some]
        return some.start + int(np.argmax(gone)) + 1 if gone.any() else None

    @property
    def elsewhere(self) -> bool:
        """Whether the nut's heat stands elsewhere than the position says."""
        return self._machine.shift_mm != 0.0

    @property
    def warm(self) -> Array:
        """Thermometers, (m,) bool, at which there may be heat that the model lacks."""
        return self._windows.warm

    @property
    def departs_K(self) -> Array:
        """By how much thermometers (m,) depart from the others that neither may drift nor show heat, 0: they do not."""
        return np.where((self.may_drift_K == 0.0) & (self.lacks_K == 0.0), self._windows.departs_K, 0.0)

    def forget(self, i: int) -> None:
        """Channel i has another zero from now on."""
        means = [*self._past, *self._before.values()]
        for difference in [each.difference for each in means] + [block[0] for block in self._last]:
            difference[i] = np.nan
        self._block.difference = np.where(np.arange(len(self._alone)) == i, np.nan, self._block.difference)
        self._machine.forget(i)
        self._trust(i)
        self._lacks_no_more(i)

    def forget_all(self, known: Known) -> None:
        """What has been seen says nothing any more: the model is another one, of which other parameters are known."""
        if not np.array_equal(known.whole, self._windows.known.whole):
            self._machine = Machine(known, self._heat, self._tick_s)
        self._windows.known, self._windows.departs_K = known, np.zeros(len(self._alone))
        self._past.clear()
        self._last.clear()
        self._scatter.begin()
        self._block = Block()
        for i in list(self._lacked):
            self._lacks_no_more(i)
        for i in list(self._before):
            self._trust(i)

    def _close(self, block: Block, now_s: float) -> int | None:
        """The end of a block: which channel has failed often enough."""
        self._machine.block(block.ticks)
        self._windows.noisier = self._scatter.times(self._noise**2)
        self._scatter.fade(np.exp(-block.ticks * self._tick_s / FORGOTTEN_S))
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
        difference, doubt = (sum(each) / MEAN for each in zip(*self._last, strict=True))
        self._blocks += 1
        self._past.append(Means(self._blocks, difference, doubt, self._rough_K))
        found, warm = self._windows.departures(self._past), self._windows.warm
        departed = [one for one in found if not warm[one.channel] or one.not_heat > 1.0]
        departed += [Departure(self._past[-1], -1, 0.0, 0.0, 0.0, 0.0)]
        most = max(departed, key=lambda one: one.may_drift)
        self._suspect([one for one in departed if one.before is most.before and one.may_drift > 1.0], now_s)
        self._compare_heat()
        worst = max(departed, key=lambda one: one.drifts)
        failed = worst.channel if worst.drifts > 1.0 else -1
        self._times = self._times + 1 if failed >= 0 and failed == self._failed else 1
        self._failed, self.departed_K = failed, max(worst.off_K, abs(self.may_drift_K[failed]))
        return failed if failed >= 0 and self._times >= IN_A_ROW else None

    def _suspect(self, departed: list[Departure], now_s: float) -> None:
        """Some are suspected, anew or still; suspicions of what is explained again pass."""
        self.heated[:] = False
        for one in departed:
            i = one.channel
            self._before[i] = min(self._before.get(i, one.before), one.before, key=lambda means: means.block)
            self.since_s[i] = np.fmin(self.since_s[i], now_s)
        for i, before in list(self._before.items()):
            change, at = self._windows.change(before, self._past[-1])
            if i in at:
                tested = self._tested(i, change, at)
                self.may_drift_K[i] = tested.value
                self.heated[i] = tested.is_heat
                if tested.is_heat:
                    self._lacked[i], self._warm_to[i] = before, self._blocks + WINDOWS[-1]
                if tested.is_heat or abs(tested.value) <= USUAL * tested.sd:
                    self._trust(i)

    def _compare_heat(self) -> None:
        """By how much thermometers depart by heat that the model lacks."""
        for i, before in list(self._lacked.items()):
            change, at = self._windows.change(before, self._past[-1])
            if i in at:
                tested = self._tested(i, change, at)
                self.lacks_K[i] = tested.value
                if abs(tested.value) > USUAL * tested.sd:
                    self._warm_to[i] = self._blocks + WINDOWS[-1]
            if self._blocks > self._warm_to[i]:
                self._lacks_no_more(i)
        self._windows.warm = self._blocks <= self._warm_to

    def _lacks_no_more(self, i: int) -> None:
        """Nothing says any more that channel i reads heat that the model lacks."""
        self._lacked.pop(i, None)
        self.lacks_K[i] = 0.0

    def _tested(self, i: int, change: Change, at: Array) -> Tested:
        """Thermometer i by those that are not suspected, nor depart nearly as far: these may drift alike."""
        rest = at[~np.isin(at, [i, *self._before])]
        tested = change.tested(i, rest, AS_IT_IS)
        alike = np.abs(tested.others.value) > ALIKE * abs(tested.value)
        return change.tested(i, rest[~alike], AS_IT_IS) if alike.any() else tested

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
