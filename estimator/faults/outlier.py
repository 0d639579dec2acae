"""Which of several thermometers has changed as neither the model nor the others explain.

    c      ~ N(0, C),  C = s^2 (D D' + A) + B      change of reading less model alone, (n,) K
    D      how c moves with what the model's parameters may be off by (state/doubt.py)
    A      heat that no parameter stands for: alike along the screw, and a little of each one's own
    B      what all have in common, and scatter
    s      how many times worse the model is than it says, 1 .. 128: by the likelihood of the other thermometers
    r      c less what the others say of it: inverse(C) c over the diagonal of inverse(C)

(Rasmussen and Williams 2006, 5.4.2.) A model that is as good as it says leaves little room; one that is wrong as much
as it is wrong elsewhere at the same time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimator.record import Array

SCALES = np.geomspace(1.0, 128.0, 15)


@dataclass(frozen=True)
class Unexplained:
    """Of n thermometers: what the others do not explain, r (n,) K, its sd, and the scale s that suits the others."""

    value: Array
    sd: Array
    scale: Array

    @property
    def furthest(self) -> int:
        """The one that is off by most sd; if one is wrong, this is it."""
        return int(np.argmax(np.abs(self.value) / self.sd))


def unexplained(change: Array, model: Array, scatter: Array, scales: Array = SCALES) -> Unexplained:
    """Of changes (n,), model = D D' + A and scatter = B, (n, n): each by the scale that suits the others best."""
    white = np.linalg.inv(np.linalg.cholesky(scatter))
    share, ways = np.linalg.eigh(white @ model @ white.T)
    ways = white.T @ ways
    weight = 1.0 / (1.0 + scales[:, None] ** 2 * share)  # C^-1 = ways diag(weight) ways' at each scale
    along = change @ ways
    pull, precision = (weight * along) @ ways.T, weight @ (ways**2).T
    square = (weight @ along**2)[:, None] - pull**2 / precision  # of the others alone, as is the likelihood
    best = np.argmax(np.log(weight).sum(axis=1)[:, None] - np.log(precision) - square, axis=0)
    own = np.arange(len(change))
    return Unexplained(pull[best, own] / precision[best, own], precision[best, own] ** -0.5, scales[best])
