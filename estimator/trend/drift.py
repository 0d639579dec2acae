"""Whether a parameter has changed over some runs, by how much, and since which.

    value_i = a + change f_i + noise,    f_i a step up at some run, or a straight rise from some run on to the last

The best of all these shapes is told if the same values in another order would hardly ever give one as good: under
permutations of the standardised values, so that neither their scatter nor how many shapes were tried has to be known
(Good 2005, Permutation, Parametric and Bootstrap Tests, ch. 3).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from estimator.record import Array
from estimator.trend.course import Course

FEWEST = 6  # runs: 720 orders
AT_EACH_END = 2  # runs before a change, and after it
ORDERS = 4999
SEED = 1  # the same runs give the same answer
WEEK_S = 7 * 86400.0
CAUTION = 1.0 / 9.0  # values scatter a third of what they say at least: their sd allow for a model that errs
TIRED = 1e-12


@dataclass(frozen=True)
class Drift:
    """How one parameter has changed.

    shape   "step" or "rise";   run: the first one that is another, or before which the rise began
    before  its value until then;   change: from then to the last run, with its sd
    gain    twice the nats that it explains, by the scatter of what is left
    p       that chance gives one as good, of all parameters that were asked
    """

    course: Course
    shape: str
    run: int
    before: float
    change: float
    sd: float
    gain: float
    p: float

    @property
    def share(self) -> float:
        """The change as a share of the value before; inf where that was 0."""
        return self.change / abs(self.before) if self.before else float("inf")


def drift(course: Course, start_s: Array, asked: int) -> Drift | None:
    """The best shape, and how likely chance is; None where too few runs tell of the parameter.

    start_s  (R,) of the runs, in order;   asked: how many parameters are
    """
    known = course.known
    if len(known) < FEWEST:
        return None
    value, weight = course.value[known], course.sd[known] ** -2.0
    shapes = list(_shapes(start_s[known]))
    basis = np.array([_white(each, weight) for _, _, each in shapes])
    middle = float(weight @ value / weight.sum())
    z = (value - middle) * np.sqrt(weight)
    orders = np.vstack([z, np.random.default_rng(SEED).permuted(np.tile(z, (ORDERS, 1)), axis=1)])
    left = orders - np.outer(orders @ np.sqrt(weight), np.sqrt(weight)) / weight.sum()  # without their own middle
    explained = ((left @ basis.T) ** 2).max(axis=1) / np.maximum((left**2).sum(axis=1), TIRED)
    chance = float((explained >= explained[0] - TIRED).mean())
    best = shapes[int(np.argmax((basis @ z) ** 2))]
    return _fitted(course, known, *best, min(1.0, chance * asked))


def tellable(start_s: Array, asked: int, sure: float) -> set[str]:
    """Of which shapes one, however large, would be told of runs of these dates: few runs have few orders."""
    found = set[str]()
    for name, _, each in _shapes(start_s):
        clear = drift(Course("", "", each, np.ones_like(each)), start_s, asked) if name not in found else None
        found |= {name} if clear is not None and clear.p < sure else set()
    return found


def shape(name: str, first: int, start_s: Array) -> Array:
    """A step up to 1 at a run, or a rise to 1 at the last run from the one before a run on: (R,)."""
    if name == "step":
        return (np.arange(len(start_s)) >= first).astype(float)
    since = np.maximum(start_s - start_s[first - 1], 0.0)
    return np.asarray(since / max(since[-1], TIRED))


def _shapes(start_s: Array) -> Iterator[tuple[str, int, Array]]:
    """Those that are tried: (R,) each."""
    R = len(start_s)
    for first in range(AT_EACH_END, R - AT_EACH_END + 1):
        yield "step", first, shape("step", first, start_s)
    for first in range(1, R - AT_EACH_END):
        if start_s[-1] > start_s[first - 1]:  # not of runs of one date
            yield "rise", first, shape("rise", first, start_s)


def _white(shape: Array, weight: Array) -> Array:
    """A shape without what a constant explains of it, of length 1 in standardised values."""
    root = np.sqrt(weight)
    white = (shape - weight @ shape / weight.sum()) * root
    return np.asarray(white / max(np.sqrt(white @ white), TIRED))


def _fitted(course: Course, known: Array, name: str, first: int, shape: Array, p: float) -> Drift:
    """The change by weighted least squares; its sd by what is left of the values."""
    value, root = course.value[known], 1.0 / course.sd[known]
    columns = np.column_stack([np.ones_like(shape), shape])
    (before, change), *_ = np.linalg.lstsq(columns * root[:, None], value * root, rcond=None)
    left = float((((value - columns @ (before, change)) * root) ** 2).sum())
    scatter = max(CAUTION, left / (len(value) - 3))  # the constant, the size and the run are three
    sd = float(np.sqrt(scatter * np.linalg.inv((columns * root[:, None]).T @ (columns * root[:, None]))[1, 1]))
    return Drift(course, name, int(known[first]), float(before), float(change), sd, float((change / sd) ** 2), p)
