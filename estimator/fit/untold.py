"""Parameters that some recordings cannot tell from others."""

from collections.abc import Sequence

import numpy as np
import scipy

from estimator.record import Array

APART = 0.02  # what is left of a column without the others, over itself: below it the column is made of them
EARLIER = 1e-6  # by so much a column is smaller than the one before it, so that of two alike the first is kept


def untold(columns: Array, names: Sequence[str]) -> dict[str, str]:
    """Names of the columns (N, p) that are combinations of those kept, each with the kept one it is most like.

    One without influence is like none (""). Of two that are alike the first is kept.
    """
    norms = np.linalg.norm(columns, axis=0)
    found = {name: "" for name, norm in zip(names, norms, strict=True) if norm == 0.0}
    if len(found) == len(names):
        return found
    seen = norms > 0.0
    first = 1.0 - EARLIER * np.arange(seen.sum())
    _, r, order = scipy.linalg.qr(columns[:, seen] / norms[seen] * first, mode="economic", pivoting=True)
    sorted_names = [[name for name in names if name not in found][i] for i in order]
    kept = int((np.abs(np.diag(r)) > APART).sum())
    for i, name in enumerate(sorted_names[kept:], kept):
        shares = np.abs(scipy.linalg.solve_triangular(r[:kept, :kept], r[:kept, i]))
        found[name] = sorted_names[int(shares.argmax())]
    return found
