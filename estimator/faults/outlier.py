"""Which of several thermometers has changed as neither the model nor the others explain.

    c      ~ N(0, C),  C = s^2 (D D' + A) + B      change of reading less model alone, (n,) K
    D      how c moves with what the model's parameters and the place of the nut's heat may be off by (state/doubt.py),
           and must be (machine.py)
    A      heat that no parameter stands for: alike along the screw, and a little of each one's own
    B      what all have in common, and scatter
    s      how many times worse the model is than it says, 1 .. 128: by the likelihood of the other thermometers
    r      c less what the others say of it: inverse(C) c over the diagonal of inverse(C)

(Rasmussen and Williams 2006, 5.4.2.) A model that is as good as it says leaves little room; one that is wrong as much
as it is wrong elsewhere at the same time. The one that is off by most sd is tested, by those that are left without the
next one: two that fail together do not hide each other.

    limit  (7 + 4 ln s) sd + 0.4 s rough + 8 beside, beyond which it drifts; with 9 for 7 in windows of more than ten
           minutes, in which more adds up that a model lacks; with 4 for 7, beyond which it may drift
    rough  how much the model alone has gone up and down in that time beside what its neighbours say of it: where that
           is rough, a model that is wrong is rough too
    beside what the next thermometers leave unexplained beyond 2 sd, found without this one; forgotten within minutes,
           like s: heat that the model lacks moves them too
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from estimator.faults.machine import Known
from estimator.record import Array

WINDOWS = (6, 14, 32, 62, 182, 362)  # blocks of 10 s
SURE = (7.0, 7.0, 7.0, 7.0, 9.0, 9.0)  # sd
SUSPECT, WORSE, ROUGH, BESIDE, USUAL = 4.0, 4.0, 0.4, 8.0, 2.0
ALIKE_MM, COMMON_K, SMOOTH_K, SINGLE_K = 250.0, 5.0, 0.01, 0.003  # of c along the screw; the last two in two minutes
TWO_MINUTES = 12  # blocks
KEPT, KEPT_SCALE = 0.9, 0.95  # of what the last block has shown
FEWEST = 5  # thermometers, of which one can be told from the others
ROUGH_SINGLE_K = 0.05  # of what the model alone changes by, beside 1 K that is alike along the screw
SCALES = np.geomspace(1.0, 128.0, 15)
AS_IT_IS = np.ones(1)  # the scale of a model that is as good as it says


@dataclass(frozen=True)
class Unexplained:
    """Of n thermometers: what the others do not explain, r (..., n) K, its sd, and the scale s that suits them."""

    value: Array
    sd: Array
    scale: Array

    @property
    def furthest(self) -> int:
        """The one that is off by most sd; if one is wrong, this is it."""
        return int(np.argmax(np.abs(self.value) / self.sd))


def unexplained(change: Array, model: Array, scatter: Array, scales: Array = SCALES) -> Unexplained:
    """Of changes (..., n), model = D D' + A (..., n, n), scatter = B (n, n): each by the scale that suits the others
    best."""
    if len(scales) == 1:  # of most blocks nothing else is asked
        inverse = np.linalg.inv(scales[0] ** 2 * model + scatter)
        precision = np.diagonal(inverse, axis1=-2, axis2=-1)
        value = (inverse @ change[..., None])[..., 0] / precision
        return Unexplained(value, precision**-0.5, np.full_like(value, scales[0]))
    white = np.linalg.inv(np.linalg.cholesky(scatter))
    share, ways = np.linalg.eigh(white @ model @ white.T)
    ways = white.T @ ways
    weight = 1.0 / (1.0 + scales[:, None] ** 2 * share[..., None, :])  # C^-1 = ways diag(weight) ways' at each scale
    along = change[..., None, :] @ ways
    pull, precision = (weight * along) @ ways.mT, weight @ (ways**2).mT
    square = weight @ along.mT**2 - pull**2 / precision  # of the others alone, as is the likelihood
    likelihood = np.log(weight).sum(axis=-1)[..., None] - np.log(precision) - square
    best = np.argmax(likelihood, axis=-2, keepdims=True)
    pull, precision = (np.take_along_axis(each, best, axis=-2)[..., 0, :] for each in (pull, precision))
    return Unexplained(pull / precision, precision**-0.5, scales[best[..., 0, :]])


@dataclass(frozen=True)
class Tested:
    """Thermometer i by the others: what they do not explain, K, its sd, their scale; and what they leave themselves.

    rest    (n - 1,) which they are;   others: what each leaves unexplained without i
    """

    value: float
    sd: float
    scale: float
    rest: Array
    others: Unexplained


@dataclass(frozen=True)
class Change:
    """Of reading less model alone over a window, or some, (..., m) K, NaN: not known; what explains it (..., m, m), and
    scatter (m, m); rough (..., m) K."""

    value: Array
    model: Array
    scatter: Array
    rough: Array

    def of(self, some: Array, scales: Array) -> Unexplained:
        """What some of them leave of each other unexplained."""
        both = (..., some[:, None], some)
        return unexplained(self.value[..., some], self.model[both], self.scatter[both], scales)

    def over(self, which: int | Sequence[int]) -> Change:
        """One window or some of several."""
        return Change(self.value[which], self.model[which], self.scatter, self.rough[which])

    def tested(self, i: int, at: Array, scales: Array) -> Tested:
        """Thermometer i by the others of those `at`, but for the one of them that is furthest off."""
        rest = at[at != i]
        others = self.of(rest, scales)
        last = self.of(np.append(np.delete(rest, others.furthest), i), scales)
        return Tested(float(last.value[-1]), float(last.sd[-1]), float(last.scale[-1]), rest, others)


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
    drifts, and of that beyond which it may."""

    before: Means
    channel: int
    off_K: float
    drifts: float
    may_drift: float


class Windows:
    """Compares thermometers over each of the WINDOWS; remembers for minutes how wrong the model has been.

    known, share  how well its parameters are known, and by which share of their values they are off nevertheless
    place_mm      by how much the nut's heat may stand elsewhere than the position says
    """

    def __init__(self, x_mm: Array, variance: Array, known: Known) -> None:
        """x_mm (m,) places along the screw, NaN: a channel without neighbours; variance (m,) of a mean, K^2."""
        self.known, self.share, self.place_mm = known, 0.0, 0.0
        self._x, self._scatter = x_mm, COMMON_K**2 + np.diag(2.0 * variance)
        self._alike = np.exp(-0.5 * ((x_mm[:, None] - x_mm) / ALIKE_MM) ** 2)
        self._unknown = SMOOTH_K**2 * self._alike + SINGLE_K**2 * np.eye(len(x_mm))  # in two minutes
        self._beside_neighbours = cache(self._neighbours_of)
        self._beside, self._scale = np.zeros((len(WINDOWS), len(x_mm))), np.ones(len(WINDOWS))

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
        change = self._changes([before], now).over(0)
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

    def _at(self, change: Change) -> Array:
        """The thermometers of which one change is known, if these are enough."""
        at = np.flatnonzero(np.isfinite(change.value + self._x))
        return at if len(at) >= FEWEST else at[:0]

    def _off(self, changes: Change) -> Iterator[tuple[int, Change, Array]]:
        """Of several changes those in which any may be beyond its limit, by number: most never are, and the rest is not
        asked. All that are known of the same thermometers at once."""
        alike: dict[tuple[int, ...], list[int]] = {}
        for w in range(len(changes.value)):
            alike.setdefault(tuple(self._at(changes.over(w)).tolist()), []).append(w)
        for known, which in alike.items():
            at, some = np.array(known, dtype=int), changes.over(which)
            first = some.of(at, AS_IT_IS)
            off = np.abs(first.value) > SUSPECT * first.sd + ROUGH * some.rough[:, at]
            yield from ((which[k], changes.over(which[k]), at) for k in np.flatnonzero(off.any(axis=1)).tolist())

    def departures(self, past: Sequence[Means]) -> Iterator[Departure]:
        """Of each window that ends with the last block, the thermometer that is off by most sd, where any is off."""
        self._beside *= KEPT
        self._scale = np.maximum(1.0, KEPT_SCALE * self._scale)
        before = [past[-1 - blocks] for blocks in WINDOWS if len(past) > blocks]
        for w, change, at in self._off(self._changes(before, past[-1])) if before else ():
            scales = np.maximum(SCALES, self._scale[w])
            i = int(at[change.of(at, scales).furthest])
            tested = change.tested(i, at, scales)
            self._scale[w] = tested.scale
            self._beside[w, i] = max(self._beside[w, i], self._beyond_usual(i, tested))
            allowed = WORSE * np.log(tested.scale) * tested.sd + ROUGH * tested.scale * change.rough[i]
            limit = np.array([SURE[w], SUSPECT]) * tested.sd + allowed + BESIDE * self._beside[w, i]
            yield Departure(before[w], i, abs(tested.value), *(abs(tested.value) / limit).tolist())

    def _beyond_usual(self, i: int, tested: Tested) -> float:
        """What the next thermometers to both sides leave unexplained beyond what is usual."""
        beyond = np.maximum(np.abs(tested.others.value) - USUAL * tested.others.sd, 0.0)
        away = self._x[tested.rest] - self._x[i]
        sides = [np.where(side * away > 0, side * away, np.inf) for side in (-1, 1)]
        return max(float(beyond[np.argmin(side)]) for side in sides if np.isfinite(side).any())
