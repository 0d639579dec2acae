"""Which of several thermometers has changed as neither the model nor the others explain.

    c      ~ N(0, C),  C = s^2 (D D' + A) + B      change of reading less model alone, (n,) K
    D      how c moves with what the model's parameters and the place of the nut's heat may be off by (state/doubt.py),
           and must be (machine.py)
    A      heat that no parameter stands for: alike along the screw, and a little of each one's own
    B      what all have in common, and scatter
    s      how many times worse the model is than it says, 1 .. 128: by the likelihood of the other thermometers
    r      c less what the others say of it: inverse(C) c over the diagonal of inverse(C)

(Rasmussen and Williams 2006, 5.4.2.) A model that is as good as it says leaves little room; one that is wrong as much
as it is wrong elsewhere at the same time. The two next to each other that are off most are tested, each by those that
are left without the next one: two that fail together do not hide each other.

What one shows that the others do not explain is its own, or heat at its place that the model lacks (local_heat.py). The
others tell which, as soon as that heat would have come to them: with h what it does to all, any multiple of it,

    r(h)   r with C + h h';   r(h) / r is 0 of heat and 1 of a drift, and its sd says whether they can tell
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from estimator.record import Array

SCALES = np.geomspace(1.0, 128.0, 15)
TINY_K = 1e-9
AS_IT_IS = np.ones(1)  # the scale of a model that is as good as it says
COLD, COLD_SDS = 0.6, 4.0  # share that is left, and in sd, without which it is no heat


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

    def off(self, k: int) -> float:
        """By how many sd thermometer number k is off."""
        return float(abs(self.value[k]) / self.sd[k])


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

    left    which share of it is left, and its sd, (2, h), where the others say how much of each of `heat` is there
    rest    (k,) which they are;   others: what each leaves unexplained without i
    """

    value: float
    sd: float
    scale: float
    left: Array
    rest: Array
    others: Unexplained

    @property
    def not_heat(self) -> float:
        """How far heat does not explain it, as a share of what makes that sure."""
        share, sd = self.left
        return float((share / np.maximum(COLD_SDS * sd, COLD)).min())

    @property
    def is_heat(self) -> bool:
        """Whether heat explains it, and the others would show it if it were none.

        More than all of it says no more than all of it: else their noise shows what little heat would do to them.
        """
        share, sd = self.left
        return bool((np.maximum(share, 0.0) < 1.0 - np.maximum(COLD_SDS * sd, COLD)).any())


@dataclass(frozen=True)
class Change:
    """Of reading less model alone over a window, or some, (..., m) K, NaN: not known; what explains it (..., m, m), and
    scatter (m, m); rough (..., m) K; heat (m, h, m) K, what heat at each or beside it does to all in one window."""

    value: Array
    model: Array
    scatter: Array
    rough: Array
    heat: Array = field(default_factory=lambda: np.empty((0, 0, 0)))

    def of(self, some: Array, scales: Array, over: Sequence[int] = ()) -> Unexplained:
        """What some of them leave of each other unexplained; `over` some of several windows."""
        both, scatter = (..., some[:, None], some), self.scatter[some[:, None], some]
        if not over:
            return unexplained(self.value[some], self.model[both], scatter, scales)
        return unexplained(self.value[over][:, some], self.model[over][both], scatter, scales)

    def over(self, which: int, heat: Array) -> "Change":
        """One of several windows, with what heat does in it."""
        return Change(self.value[which], self.model[which], self.scatter, self.rough[which], heat)

    def furthest(self, at: Array, scales: Array) -> tuple[int, int]:
        """The two next to each other of those `at` that are off most, the one that is off more without the other first.

        e' E^-1 e of each two, e and E what inverse(C) c and inverse(C) have of them; one that fails is in two of them
        """
        both, two = np.ix_(at, at), np.stack([np.arange(len(at) - 1), np.arange(1, len(at))], axis=1)
        inverse = np.linalg.inv(self.model[both] + self.scatter[both])
        e, E = (inverse @ self.value[at])[two], inverse[two[:, :, None], two[:, None]]
        i, j = at[two[np.argmax((e * np.linalg.solve(E, e[..., None])[..., 0]).sum(axis=1))]].tolist()
        rest = at[(at != i) & (at != j)]
        off_i, off_j = (self.of(np.append(rest, one), scales).off(-1) for one in (i, j))
        return (i, j) if off_i >= off_j else (j, i)

    def tested(self, i: int, rest: Array, scales: Array) -> Tested:
        """Thermometer i by some others."""
        some, others = np.append(rest, i), self.of(rest, scales)
        last = self.of(some, scales)
        value, sd, scale = (float(each[-1]) for each in vars(last).values())
        return Tested(
            value, sd, scale, self._left(some, scale, self.heat[i][:, some]) / max(abs(value), TINY_K), rest, others
        )

    def _left(self, some: Array, scale: float, heat: Array) -> Array:
        """What the others do not explain of the last of some, with its sign, and the sd of that, (2, h) K, if heat may
        warm them by any multiple of a row of (h, k) K: C + heat' heat instead of C."""
        both = np.ix_(some, some)
        inverse = np.linalg.inv(scale**2 * self.model[both] + self.scatter[both])
        ways, pull = heat @ inverse, inverse @ self.value[some]
        share = ways[:, -1] / (1.0 + (ways * heat).sum(axis=1))
        precision = inverse[-1, -1] - share * ways[:, -1]
        value = (pull[-1] - share * (heat @ pull)) / precision
        return np.array([value * np.sign(pull[-1]), precision**-0.5])
