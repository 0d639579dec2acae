"""How a run moves with parameters, tick by tick: the open-loop run ahead of the filter, the filter behind it.

The equations are those of doubt.py.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

import numpy as np

from estimator.record import Array

Carried = tuple[Array, Array, Array, Array]
Kernels = tuple[Callable[..., Carried], Callable[..., Array]]


@dataclass(frozen=True)
class Course:
    """The open-loop run over K ticks, from the tick before them on: states z (K + 1, n), spots and lagged readings
    (K + 1, m), growth of the span since the start (K,) um, and the part of a tick by which readings are late (K, m)."""

    z: Array
    spot: Array
    lagged: Array
    grown_um: Array
    late_share: Array


@dataclass(frozen=True)
class Moves:
    """How the open-loop run moves over K ticks, whatever is fused of them.

    regime, grown_um  (K,) of the run itself
    states            (K, n, q) Z of q parameters of the model;   elongation (K, q) um
    readings          (K, m, p) D of these, and then of the thermometers' own errors
    """

    regime: Array
    grown_um: Array
    states: Array
    readings: Array
    elongation: Array

    def rows(self, some: slice) -> "Moves":
        """Some of the ticks."""
        return Moves(*(getattr(self, field.name)[some] for field in fields(self)))

    @classmethod
    def joined(cls, parts: "Sequence[Moves]") -> "Moves":
        """Ticks that follow each other, as one."""
        return cls(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)))


@dataclass(frozen=True)
class Doubtful:
    """What K ticks are off by, per standard normal error of the parameters together: a (K, ..., p) has variance a a'.

    states      (K, size, p) of the full state
    elongation  (K, p) um
    """

    states: Array
    elongation: Array


def carried(
    F: Array, regime: Array, B: Array, own: Array, pushed: Array, offset: Array, late_share: Array,
    keep: Array, ramp: Array, rows: Array, Z: Array, spot: Array, lagged: Array,
) -> Carried:  # fmt: skip
    """Z (K, n, p) and D (K, m, p) with each of K ticks; spots and lagged readings (m, p) after the last.

    Written so that it can be compiled; to set a part of an array would take numba seconds more. F (R, n, n), what moves
    states B (K, n, p), spots, lagged readings and readings by itself (K, m, p); Z, spot and lagged before the
    first tick
    """
    Zs, Ds = np.empty(B.shape), np.empty(offset.shape)
    keep, ramp = keep.reshape(-1, 1), ramp.reshape(-1, 1)
    for k in range(len(B)):
        np.dot(F[regime[k]], Z, Zs[k])
        Z = Zs[k]
        Z += B[k]
        now = np.dot(rows, Z)
        now += own[k]
        lagged = keep * lagged + (1.0 - keep - ramp) * spot + ramp * now + pushed[k]
        np.add(offset[k] + lagged, (spot - now) * late_share[k].reshape(-1, 1), Ds[k])
        spot = now
    return Zs, Ds, spot, lagged


def followed(F: Array, regime: Array, H: Array, gain: Array, D: Array, S: Array) -> Array:
    """S (K, size, p) after each of K ticks, from S before them; H (K, m, size), gain (K, size, m), D (K, m, p)."""
    n = F.shape[1]
    Ss, off, taken = np.empty((len(D), *S.shape)), np.empty(D.shape[1:]), np.empty(S.shape)
    for k in range(len(D)):
        now = Ss[k]
        np.dot(F[regime[k]], S[:n], now[:n])
        np.add(S[n:], 0.0, now[n:])
        np.dot(H[k], now, off)
        off += D[k]
        np.dot(gain[k], off, taken)
        now -= taken
        S = now
    return Ss
