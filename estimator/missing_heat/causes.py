"""How large the independent causes of what was measured are: variance components by marginal likelihood.

    S = S0 + sum over k of size_k^2 C_k,      size_k^2 <- size_k^2 (a' C_k a / tr(S^-1 C_k)),      a = S^-1 y

At the most likely sizes what a cause explains is as large as was to be expected of it, in all recordings together.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from estimator.record import Array
from estimator.work import Workers

ROUNDS = 60
STEADY = 0.03  # logarithm of a variance, within which it counts as found


@dataclass(frozen=True)
class Cause:
    """One cause at size 1: covariance (r, r) of what it does to some of the averages, `rows` (r,) of them."""

    rows: Array
    covariance: Array

    def part(self, matrix: Array) -> Array:
        """Where the cause is, of a matrix (N, N); a view where it is everywhere."""
        return matrix if len(self.rows) == len(matrix) else matrix[np.ix_(self.rows, self.rows)]


@dataclass(frozen=True)
class Averages:
    """Averages y (N,) of one recording with covariance `known` (N, N) of what has no size to be found, and causes."""

    y: Array
    known: Array
    causes: Mapping[str, Cause]


@dataclass(frozen=True)
class Inverted:
    """S^-1 (N, N) and S^-1 y (N,)."""

    inverse: Array
    pull: Array


def covariance(measured: Averages, sizes: Mapping[str, float]) -> Array:
    """S (N, N) of what was measured."""
    S = measured.known.copy()
    for name, cause in measured.causes.items():
        if len(cause.rows) == len(S):
            S += sizes[name] ** 2 * cause.covariance
        else:
            S[np.ix_(cause.rows, cause.rows)] += sizes[name] ** 2 * cause.covariance
    return S


def inverted(measured: Averages, sizes: Mapping[str, float]) -> Inverted:
    """Invert the covariance that these sizes give."""
    S = covariance(measured, sizes)
    upper, fault = scipy.linalg.lapack.dpotrf(S.T, overwrite_a=True)  # in the place of S: that of a day is large
    if fault:
        raise np.linalg.LinAlgError("the covariance of the misfits is not positive definite")
    inverse = scipy.linalg.lapack.dpotri(upper, overwrite_c=True)[0].T
    inverse += np.tril(inverse, -1).T
    return Inverted(inverse, inverse @ measured.y)


def most_likely(
    found: Sequence[Averages], start: Mapping[str, float], least: Mapping[str, float], workers: Workers = map
) -> dict[str, float]:
    """Sizes of the causes, common to all recordings, from `start` on and never below `least`."""
    sizes = dict(start)
    for _ in range(ROUNDS):
        sums = dict.fromkeys(sizes, (0.0, 0.0))
        for each in workers(lambda one: _pulls(one, sizes), found):
            for name, (pull, expected) in each.items():
                sums[name] = sums[name][0] + pull, sums[name][1] + expected
        moved = 0.0
        for name, (pull, expected) in sums.items():
            if expected > 0:
                size = max(least[name], sizes[name] * float(np.sqrt(max(pull, 0.0) / expected)))
                moved, sizes[name] = max(moved, 2 * abs(np.log(size / sizes[name]))), size
        if moved < STEADY:
            break
    return sizes


def _pulls(measured: Averages, sizes: Mapping[str, float]) -> dict[str, tuple[float, float]]:
    """a' C a and tr(S^-1 C) of each cause."""
    now = inverted(measured, sizes)
    found = {}
    for name, cause in measured.causes.items():
        pull = now.pull[cause.rows]
        expected = np.vdot(cause.part(now.inverse), cause.covariance)
        found[name] = float(pull @ cause.covariance @ pull), float(expected)
    return found
