import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def _coast(F, regime, b, start, out):
    x = start.copy()
    for t in range(len(b)):
        x = np.dot(F[regime[t]], x) + b[t]
        out[t] = x


def coast(F, regime, b, start):
    c = np.ascontiguousarray
    out = np.empty(b.shape)
    _coast(c(F), c(regime), c(b), c(start), out)
    return out
