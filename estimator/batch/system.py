"""What the batch engine is given, a linear system with its readings, and what it gives back."""

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from estimator.batch.kernels import Data, Model, States
from estimator.record import Array


@dataclass(frozen=True)
class System:
    """T ticks, m channels, n states; the first d move. All numbers float64 but for the regime and the column.

    y        (T, m)     reading less offset, NaN: not measured
    regime   (T,)       whole numbers below R
    b        (T, n)     what the inputs add; 0 for the constants
    F        (R, d, d)  transition of the states that move
    Q        (R, n, n)  without covariance between states that move and constants, or among the constants
    H        (m, n)
    spans    (m,)       row o of H at tick t is H[o], with spans[o] * grown[t] added in the column
    column   of H that varies, -1: none
    grown    (T,)
    R        (T, m)     variance of a reading, inf: the channel has no model, and is not fused
    x0, P0   (n,), (n, n) filtered estimate before the first tick
    muted    (T, m)     readings that are compared but not fused; none unless given
    """

    y: Array
    regime: Array
    b: Array
    F: Array
    Q: Array
    H: Array
    spans: Array
    column: int
    grown: Array
    R: Array
    x0: Array
    P0: Array
    muted: Array | None = None

    def __post_init__(self) -> None:
        if self.muted is None:
            object.__setattr__(self, "muted", np.zeros(self.y.shape, dtype=bool))

    @cached_property
    def model(self) -> Model:
        """What the kernels need of the matrices."""
        F, Q, H, spans = (_numbers(a) for a in (self.F, self.Q, self.H, self.spans))
        spans = spans if self.column >= 0 else np.zeros(len(H))
        entries = H != 0.0
        entries[:, self.column] |= spans != 0.0
        start = np.append(0, entries.sum(axis=1).cumsum())
        places = np.ascontiguousarray(entries.nonzero()[1])  # one kind of array, however many there are
        return Model(F, np.ascontiguousarray(F.transpose(0, 2, 1)), Q, H, spans, int(self.column), start, places)

    @cached_property
    def data(self) -> Data:
        """What changes from tick to tick, and which readings to use."""
        b, y, grown, R = (_numbers(a) for a in (self.b, self.y, self.grown, self.R))
        use = np.isfinite(y) & np.isfinite(R)
        if self.muted is not None:
            use &= ~self.muted
        inverse = np.divide(1.0, R, out=np.zeros(R.shape), where=use)
        return Data(np.require(self.regime, np.int64, ["C", "W"]), b, y, grown, R, use, inverse)

    @property
    def start(self) -> States:
        """The state before the first tick, to be overwritten tick by tick."""
        return States(np.array(self.x0, dtype=float)[None], np.array(self.P0, dtype=float)[None])


def _numbers(a: Array) -> Array:
    """The array as a kernel takes it, without a copy where it is so already."""
    return np.require(a, np.float64, ["C", "W"])


@dataclass(frozen=True)
class Chunk:
    """K ticks, filtered.

    x, P       (K, n), (K, n, n) after the tick; or (1, n, n) after the last alone
    predicted  (K, m)  H x before any channel of the tick is used
    sd         (K, m)  of a reading around it, inf: no model, NaN: not asked for
    fused      (K, m)
    gain       (K, n, m) what was updated with, 0: not fused; none where it was not asked for
    nis        (K,)    e' S^-1 e of the channels fused, NaN: none
    loglike    (K,)    what the tick adds to the log-likelihood
    """

    ticks: slice
    x: Array
    P: Array
    predicted: Array
    sd: Array
    fused: Array
    gain: Array
    nis: Array
    loglike: Array

    @property
    def last(self) -> tuple[Array, Array]:
        """x and P after the last tick."""
        return self.x[-1], self.P[-1]

    def rows(self, some: slice) -> "Chunk":
        """Some of the ticks, counted from the first."""
        parts = {field.name: getattr(self, field.name)[some] for field in fields(self) if field.name != "ticks"}
        return Chunk(slice(self.ticks.start + some.start, self.ticks.start + some.stop), **parts)

    def with_last(self, tick: "Chunk") -> "Chunk":
        """With another last tick."""
        for field in fields(self):
            if field.name != "ticks":
                getattr(self, field.name)[-1:] = getattr(tick, field.name)
        return self


@dataclass(frozen=True)
class Smoothed:
    """Estimate of each tick from all readings, those after it too.

    x, var   (T, n)
    cov      (T, n, n), or (0, n, n) where not asked for
    reading  (T, k)  H x of the channels asked for;  reading_var (T, k) its variance
    """

    x: Array
    var: Array
    cov: Array
    reading: Array
    reading_var: Array


@dataclass(frozen=True)
class Score:
    """Log-likelihood and its derivatives by fields of System; those by Q and P0 are symmetric matrices S with
    dL = sum(S * dQ) for a symmetric change dQ."""

    loglike: float
    Q: Array
    y: Array
    R: Array
    grown: Array
    x0: Array
    P0: Array
