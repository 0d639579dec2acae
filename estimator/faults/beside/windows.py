"""Thermometers that leave the others, over windows of a minute to an hour.

    limit  (7 + 4 ln s) sd + 0.4 s rough + 8 beside, beyond which it drifts if heat does not explain it; with 9 for 7 in
           windows of more than ten minutes, in which more adds up that a model lacks; with 4 for 7, beyond which it may
    rough  how much the model alone has gone up and down in that time beside what its neighbours say of it: where that
           is rough, a model that is wrong is rough too
    beside what the next thermometers leave unexplained beyond 2 sd, found without the two that are tested; forgotten
           within minutes, like s: heat that the model lacks moves them too

sd and s are those of change.py.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from estimator.faults.beside.change import AS_IT_IS, SCALES, Change, Tested, Unexplained
from estimator.faults.beside.local_heat import BEGINS, local_heats
from estimator.faults.machine import Known
from estimator.record import Array
from estimator.screw import Screw

BLOCK_S = 10.0
WINDOWS = (6, 14, 32, 62, 182, 362)  # blocks
SURE = (7.0, 7.0, 7.0, 7.0, 9.0, 9.0)  # sd
SUSPECT, WORSE, BESIDE, USUAL = 4.0, 4.0, 8.0, 2.0
ROUGH = 0.4  # of what the model alone changes by beside the next places: more than it can lack there
ROUGH_K, LARGE, OFF = 0.05, 0.05, 1.6  # a suspicion needs no more, of what is large: so many times what it is off by
ALIKE_MM, COMMON_K, SMOOTH_K, SINGLE_K = 250.0, 5.0, 0.01, 0.003  # of c along the screw; the last two in two minutes
TWO_MINUTES = 12  # blocks
RECENT = 4  # of the windows: ten minutes
KEPT, KEPT_SCALE = 0.9, 0.95  # of what the last block has shown
STEADY = 0.4  # of a departure that is there half way through its time
WARMED = 64  # times whose local heats are kept
FEWEST = 5  # thermometers, of which one can be told from the others
ROUGH_SINGLE_K = 0.05  # of what the model alone changes by, beside 1 K that is alike along the screw


@dataclass(frozen=True)
class Means:
    """Over some blocks up to that one, (m, ...): reading less model alone, how that moves with parameters; how rough
    the model has been up to then."""

    block: int
    difference: Array
    doubt: Array
    rough: Array


@dataclass(frozen=True)
class Departure:
    """The thermometer that is off by most sd since some blocks: how far, K, as a share of the limit beyond which it
    drifts, and of that beyond which it may; and of what heat explains."""

    before: Means
    channel: int
    off_K: float
    drifts: float
    may_drift: float
    not_heat: float


class Windows:
    """Compares thermometers over each of the WINDOWS; remembers for minutes how wrong the model has been.

    known, share  how well its parameters are known, and by which share of their values they are off nevertheless
    place_mm      by how much the nut's heat may stand elsewhere than the position says
    departs_K     (m,) by how much each departs most from the others in ten minutes; models may lack as much
    noisier       by how many times as large a variance thermometers scatter as the model says, at least 1
    warm          (m,) bool, where there has been heat that the model lacks, which may go on, or have ended, as well
    """

    def __init__(self, x_mm: Array, variance: Array, known: Known, screw: Screw | None) -> None:
        """x_mm (m,) places along the screw, NaN: a channel without neighbours; variance (m,) of a mean, K^2."""
        self.known, self.share, self.place_mm = known, 0.0, 0.0
        self._x, self._variance, self.noisier = x_mm, variance, 1.0
        self._order = np.argsort(x_mm)
        self._alike = np.exp(-0.5 * ((x_mm[:, None] - x_mm) / ALIKE_MM) ** 2)
        self._unknown = SMOOTH_K**2 * self._alike + SINGLE_K**2 * np.eye(len(x_mm))  # in two minutes
        self.warm, self.departs_K = np.zeros(len(x_mm), dtype=bool), np.zeros(len(x_mm))
        self._beside_neighbours = cache(self._neighbours_of)
        self._heats = lru_cache(WARMED)(lambda blocks: local_heats(x_mm, screw, blocks * BLOCK_S))
        self._beside, self._scale = np.zeros((len(WINDOWS), len(x_mm))), np.ones(len(WINDOWS))

    @property
    def furthest(self) -> Array:
        """The thermometer that departs most, if any does, (m,) bool: it may drift, and is no witness of the model.

        Where that is another machine's, the others are enough to tell.
        """
        return np.asarray((self.departs_K > 0.0) & (self.departs_K == self.departs_K.max()))

    @property
    def _scatter(self) -> Array:
        """What all changes have in common, and scatter, (m, m) K^2."""
        return np.asarray(COMMON_K**2 + np.diag(2.0 * self.noisier * self._variance))

    def rough(self, change: Array) -> Array:
        """How far the model alone has changed beside what it says of the neighbours, (m,) K."""
        known = np.isfinite(self._x + change)
        return np.abs(self._beside_neighbours(known.tobytes()) @ np.where(known, change, 0.0))

    def _neighbours_of(self, known: bytes) -> Array:
        """Matrix (m, m) that takes off changes, where they are `known`, what the neighbours say of each."""
        at = np.flatnonzero(np.frombuffer(known, dtype=bool))
        both, matrix = np.ix_(at, at), np.zeros(2 * self._x.shape)
        inverse = np.linalg.inv(self._alike[both] + COMMON_K**2 + ROUGH_SINGLE_K**2 * np.eye(len(at)))
        matrix[both] = inverse / np.diag(inverse)[:, None]
        return matrix

    def change(self, before: Means, now: Means) -> tuple[Change, Array]:
        """The change between two times, and of which thermometers it is known: of enough of them, or of none."""
        change = self._changes([before], now).over(0, self._heat(before, now))
        return change, self._at(change)

    def _changes(self, before: Sequence[Means], now: Means) -> Change:
        """Those since several times."""
        difference, doubt, rough = (
            getattr(now, key) - np.array([getattr(means, key) for means in before])
            for key in ("difference", "doubt", "rough")
        )
        moved = self.known.doubtful(doubt, np.full(len(before), self.share))
        blocks = np.array([now.block - means.block for means in before])
        if self.known.shift is not None:
            moved = np.concatenate([moved, self.place_mm * doubt[..., [self.known.shift]]], axis=-1)
        model = moved @ moved.mT + (blocks / TWO_MINUTES)[:, None, None] * self._unknown
        return Change(difference, model, self._scatter, rough)

    def _heat(self, before: Means, now: Means) -> Array:
        """What heat does between two times, (m, h, m) K."""
        heat = self._heats(now.block - before.block).copy()
        heat[~self.warm, BEGINS:] = 0.0
        return heat

    def _at(self, change: Change) -> Array:
        """The thermometers of which one change is known, in order of place, if these are enough."""
        return self._enough(np.isfinite(change.value + self._x))

    def _enough(self, known: Array) -> Array:
        """Those that are `known` (m,), in order of place, if these are enough."""
        at = self._order[known[self._order]]
        return at if len(at) >= FEWEST else at[:0]

    def _off(self, changes: Change) -> Iterator[tuple[int, Array]]:
        """Of several changes those in which any may be beyond its limit, by number, with the thermometers that are
        known: most never are, and the rest is not asked. All that are known of the same thermometers at once."""
        alike: dict[bytes, list[int]] = {}
        for w, known in enumerate(np.isfinite(changes.value + self._x)):
            alike.setdefault(known.tobytes(), []).append(w)
        for same, which in alike.items():
            at = self._enough(np.frombuffer(same, dtype=bool))
            first = changes.of(at, AS_IT_IS, which)
            self._depart(first, at, np.array(which) < RECENT)
            off = np.abs(first.value) > SUSPECT * first.sd + self._details(changes.rough[which][:, at])
            yield from ((which[k], at) for k in np.flatnonzero(off.any(axis=1)).tolist())

    def _depart(self, first: Unexplained, at: Array, recent: Array) -> None:
        """How far those `at` depart over those of some windows that are recent."""
        off_K = np.abs(first.value) * recent[:, None]
        self.departs_K[at] = np.maximum(
            self.departs_K[at], np.where(off_K > SUSPECT * first.sd, off_K, 0.0).max(axis=0)
        )

    def departures(self, past: Sequence[Means]) -> Iterator[Departure]:
        """Of each window that ends with the last block, the thermometer that is off by most sd, where any is off."""
        self.departs_K = np.zeros(len(self._x))
        self._beside *= KEPT
        self._scale = np.maximum(1.0, KEPT_SCALE * self._scale)
        before = [past[-1 - blocks] for blocks in WINDOWS if len(past) > blocks]
        if not before:
            return
        changes = self._changes(before, past[-1])
        for w, at in self._off(changes):
            change = changes.over(w, self._heat(before[w], past[-1]))
            scales = np.maximum(SCALES, self._scale[w])
            two = change.furthest(at, scales)
            rest = self._rest(change, at[~np.isin(at, two)], scales)
            alone = [change.tested(i, rest, scales) for i in two]
            self._scale[w] = alone[0].scale
            for i, j, tested, other in zip(two, two[::-1], alone, alone[::-1], strict=True):
                if self.warm[j] or abs(other.value) <= SUSPECT * other.sd:  # it is well, and may tell of heat
                    tested = change.tested(i, np.append(rest, j), scales)
                steady = _steady(i, rest, [past[-1 - blocks].difference for blocks in (WINDOWS[w], WINDOWS[w] // 2, 0)])
                yield self._departure(w, before[w], i, tested, change, steady)

    def _details(self, rough: Array) -> Array:
        """By how much places may change otherwise than the next ones, K, where the model alone has changed beside them
        by `rough`."""
        return np.minimum(ROUGH * rough, ROUGH_K + (LARGE + OFF * self.share) * rough)

    def _rest(self, change: Change, rest: Array, scales: Array) -> Array:
        """Of more than are needed all but the one that is furthest off, if that is not heat."""
        last = change.of(rest, scales).furthest
        return rest if len(rest) < FEWEST or self.warm[rest[last]] else np.delete(rest, last)

    def _departure(self, w: int, before: Means, i: int, tested: Tested, change: Change, steady: bool) -> Departure:
        """How far one has departed over window w; if not steadily, it may be heat that came late in it."""
        self._beside[w, i] = max(self._beside[w, i], self._beyond_usual(i, tested))
        details = np.array([ROUGH * change.rough[i], self._details(change.rough[i])])
        allowed = WORSE * np.log(tested.scale) * tested.sd + tested.scale * details
        limit = np.array([SURE[w], SUSPECT]) * tested.sd + allowed + BESIDE * self._beside[w, i]
        drifts, may_drift = (abs(tested.value) / limit).tolist()
        not_heat = tested.not_heat if steady else 0.0
        return Departure(before, i, abs(tested.value), min(drifts, not_heat), may_drift, not_heat)

    def _beyond_usual(self, i: int, tested: Tested) -> float:
        """What the next thermometers to both sides leave unexplained beyond what is usual."""
        beyond = np.maximum(np.abs(tested.others.value) - USUAL * tested.others.sd, 0.0)
        away = self._x[tested.rest] - self._x[i]
        sides = [np.where(side * away > 0, side * away, np.inf) for side in (-1, 1)]
        return max(float(beyond[np.argmin(side)]) for side in sides if np.isfinite(side).any())


def _steady(i: int, rest: Array, differences: Sequence[Array]) -> bool:
    """Whether thermometer i had departed from the others, of three times (m,), by STEADY of it by the second."""
    before, half, whole = (difference[i] - difference[rest].mean() for difference in differences)
    return bool((half - before) * np.sign(whole - before) >= STEADY * abs(whole - before))
