"""A whole recording at once: likelihood, smoother, derivatives, and effects taken through the filter as columns.

    predict   x <- F x + b         P <- F P F' + Q
    compare   e = y - H x          S = H P H' + R
    update    x <- x + K e         K = P H' S^-1

The first d states move; the others are constants, which may walk: F is the identity there and Q diagonal. Every tick
predicts, then updates. Where all ticks do not fit into memory at once they are filtered twice: once to the end, keeping
the state at the borders of chunks, and once more chunk by chunk on the way back.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from estimator import kernels
from estimator.kernels import LANES, Adjoint, Compared, Data, Gains, Model, Slopes, Smooth, States
from estimator.record import Array

BUDGET = 250_000_000  # bytes for what is kept of each tick until the way back
NEAR = 2_000_000  # bytes that stay close to the processor, for what is used up at once

Columns = Callable[[slice], tuple[Array, Array]]


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
    muted    (T, m)     readings that are compared but not fused
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

    @cached_property
    def model(self) -> Model:
        """The matrices, padded."""
        n, d = len(self.x0), self.F.shape[1]
        size, moving = _padded(n), _padded(d)
        F = np.zeros((len(self.F), moving, moving))
        F[:, np.arange(moving), np.arange(moving)] = 1.0
        F[:, :d, :d] = self.F
        Q, H = np.zeros((len(self.F), size, size)), np.zeros((len(self.H), size))
        Q[:, :n, :n], H[:, :n] = self.Q, self.H
        entries = H != 0.0
        if self.column >= 0:
            entries[:, self.column] |= self.spans != 0.0
        pieces = entries.reshape(len(H), -1, LANES).any(axis=2)
        start, first = (np.append(0, some.sum(axis=1).cumsum()) for some in (entries, pieces))
        places, lanes = entries.nonzero()[1], LANES * pieces.nonzero()[1]
        spans = np.array(self.spans, dtype=float)
        return Model(F, F.transpose(0, 2, 1).copy(), Q, H, start, places, first, lanes, int(self.column), spans)

    @cached_property
    def data(self) -> Data:
        """What changes from tick to tick, and which readings to use."""
        b, y, R, grown = (np.require(a, np.float64, ["C", "W"]) for a in (self.b, self.y, self.R, self.grown))
        use = np.isfinite(y) & np.isfinite(R)
        if self.muted is not None:
            use &= ~self.muted
        return Data(np.require(self.regime, np.int64, ["C", "W"]), b, y, use, R, grown)

    @property
    def start(self) -> States:
        """The state before the first tick, to be overwritten tick by tick."""
        n, size = len(self.x0), self.model.H.shape[1]
        states = States(np.zeros((1, size)), np.zeros((1, size, size)))
        states.x[0, :n], states.P[0, :n, :n] = self.x0, self.P0
        return states


@dataclass(frozen=True)
class Gate:
    """A reading beyond `sd` standard deviations is not fused; after `stubborn` such ticks in a row it is believed."""

    sd: float = 10.0
    stubborn: int = 5


@dataclass(frozen=True)
class Chunk:
    """K ticks, filtered.

    x, P       (K, n), (K, n, n) after the tick
    predicted  (K, m)  H x before any channel of the tick is used
    sd         (K, m)  of a reading around it, inf: no model
    fused      (K, m)
    nis        (K,)    e' S^-1 e of the channels fused, NaN: none
    loglike    (K,)    what the tick adds to the log-likelihood
    """

    ticks: slice
    x: Array
    P: Array
    predicted: Array
    sd: Array
    fused: Array
    nis: Array
    loglike: Array


@dataclass(frozen=True)
class Smoothed:
    """Estimate of each tick from all readings; r tells what an impulse in the inputs would explain, N its variance.

    x, var   (T, n)
    cov      (T, n, n), or (0, n, n) where not asked for
    r        (T, n)  derivative of the log-likelihood by b
    along_r  (T, k)  weights @ r
    along_N  (T, k)  variance of it if the model is right: weights @ N @ weights
    """

    x: Array
    var: Array
    cov: Array
    r: Array
    along_r: Array
    along_N: Array


@dataclass(frozen=True)
class Score:
    """Log-likelihood and its derivatives by the fields of System; those by Q and P0 are symmetric matrices S with
    dL = sum(S * dQ) for a symmetric change dQ. H: of the rows asked for, else 0."""

    loglike: float
    F: Array
    Q: Array
    b: Array
    y: Array
    R: Array
    H: Array
    grown: Array
    x0: Array
    P0: Array


def is_cold(*functions: Callable[..., Any]) -> bool:
    """Whether any of these functions of this module, or of all, is still to be compiled: some seconds each, once."""
    forward = kernels.forward
    needs: dict[Callable[..., Any], tuple[Any, ...]] = {
        loglike: (forward,),
        passes: (kernels.compare,),
        smoothed: (forward, kernels.smooth),
        score: (forward, kernels.score),
        gram: (forward, kernels.columns),
        ahead: (forward, kernels.ahead),
        open_loop: (kernels.open_loop,),
    }
    return not all(_is_compiled(kernel) for function in functions or needs for kernel in needs[function])


def passes(system: System, gate: Gate | None = None) -> Iterator[Chunk]:
    """Filter, chunk by chunk. The gate compares every reading, also those that are not to be fused."""
    n, m = len(system.x0), len(system.H)
    gate = gate or Gate(sd=np.inf)
    model, wild, gains, before = system.model, np.zeros(m, dtype=np.int64), _gains(system, 1), system.start
    for ticks in _chunks(system, model.H.shape[1] ** 2, NEAR):
        K = ticks.stop - ticks.start
        states = States(*(np.empty((K + 1, *a.shape[1:])) for a in before))
        states.x[0], states.P[0] = before.x[0], before.P[0]
        fused = np.empty((K, m), dtype=bool)
        out = Compared(np.empty((K, m)), np.empty((K, m)), fused, np.empty(K), np.empty(K))
        data = _part(system.data, ticks)
        kernels.compare(model, data, float(gate.sd), int(gate.stubborn), wild, states, gains, out)
        before = States(states.x[-1:].copy(), states.P[-1:].copy())
        yield Chunk(ticks, states.x[1:, :n], states.P[1:, :n, :n], *out)


def loglike(system: System) -> float:
    """Log-likelihood of the readings."""
    return float(kernels.forward(system.model, system.data, system.start, _gains(system, 1)))


def smoothed(system: System, covariances: bool = False, along: Array | None = None) -> Smoothed:
    """Estimate of each tick from all readings; also of r and N of each tick along the given weights (k, n)."""
    T, n = system.b.shape
    weights = np.zeros((0 if along is None else len(along), system.model.H.shape[1]))
    weights[:, :n] = 0.0 if along is None else along
    k = len(weights)
    result = Smoothed(np.empty((T, n)), np.empty((T, n)), np.empty((T if covariances else 0, n, n)), np.empty((T, n)),
                      np.empty((T, k)), np.empty((T, k)))  # fmt: skip
    adjoint = _adjoint(system)
    for ticks, states, gains, _ in _backwards(system):
        x, var, cov, r, along_r, along_N = (a[ticks] for a in vars(result).values())
        out = Smooth(x, var, cov, r, weights, along_r, along_N)
        kernels.smooth(system.model, _part(system.data, ticks), states, gains, adjoint, out)
    return result


def score(system: System, rows: Array | None = None) -> Score:
    """Log-likelihood and its exact derivatives; rows (m,): the channels for which that by H is wanted."""
    (T, n), m, d = system.b.shape, len(system.H), system.F.shape[1]
    model, adjoint, total = system.model, _adjoint(system), 0.0
    wanted = np.zeros(m, dtype=bool) if rows is None else np.array(rows, dtype=bool)
    F, Q, H = np.zeros_like(model.F), np.zeros_like(model.Q), np.zeros_like(model.H)
    out = Slopes(np.empty((T, n)), np.zeros((T, m)), np.zeros((T, m)), np.zeros(T), F, Q, H)
    for ticks, states, gains, value in _backwards(system):
        part = Slopes(out.b[ticks], out.y[ticks], out.R[ticks], out.grown[ticks], F, Q, H)
        kernels.score(model, _part(system.data, ticks), wanted, states, gains, adjoint, part)
        total += value
    r, N = adjoint.r[0, :n].copy(), adjoint.N[:n, :n]
    F, Q, H = F[:, :d, :d].copy(), 0.5 * Q[:, :n, :n], H[:, :n].copy()
    return Score(total, F, Q, out.b, out.y, out.R, H, out.grown, r, 0.5 * (np.outer(r, r) - N))


def gram(system: System, columns: Columns, k: int, start: Array | None = None, blocks: Array | None = None) -> Array:
    """Gram matrices (blocks, k + 1, k + 1) of k effects and, last, of the data, after the filter has whitened them.

    columns(ticks) gives what each effect adds to b, (K, n, k), and to the readings, (K, m, k); start (n, k), to x0.
    blocks (T,): to which of the matrices a tick adds, as whole numbers; else there is one. With their sum G,

        loglike(b + B a, y - D a, x0 + start a) = loglike + g a - a G a / 2      g = G[:k, k], G = G[:k, :k]

    so that the best amplitudes a solve G a = g.
    """
    (T, n), model = system.b.shape, system.model
    width = _padded(k + 1)
    X = np.zeros((model.H.shape[1], width))
    X[:n, :k] = 0.0 if start is None else start
    block = np.zeros(T, dtype=np.int64) if blocks is None else np.require(blocks, np.int64, ["C", "W"])
    G = np.zeros((int(block.max(initial=0)) + 1, width, width))
    chunks = _chunks(system, model.H.size + (n + len(model.H)) * k, NEAR)
    states, gains = system.start, _gains(system, chunks[0].stop)
    for ticks in chunks:
        data = _part(system.data, ticks)
        kernels.forward(model, data, states, gains)
        B, D = (np.require(a, np.float64, ["C", "W"]) for a in columns(ticks))
        kernels.columns(model, data, B, D, block[ticks], gains, X, G)
    above = np.triu(G)
    return (above + np.triu(G, 1).transpose(0, 2, 1))[:, : k + 1, : k + 1]


def ahead(system: System, steps: int, every: int) -> tuple[Array, Array]:
    """Starts 0, every, 2 every ... (S,) and what each channel reads `steps` later without a reading since, (S, m)."""
    starts = np.arange(0, max(len(system.y) - steps, 0), every)
    states, gains, data = system.start, _gains(system, 1), system.data
    x = np.zeros((len(starts), len(states.x[0])))
    done = 0
    for s, start in enumerate(starts):
        kernels.forward(system.model, _part(data, slice(done, int(start) + 1)), states, gains)
        x[s], done = states.x[0], int(start) + 1
    readings = np.empty((len(starts), len(system.H)))
    kernels.ahead(system.model, data, starts, int(steps), x, readings)
    return starts, readings


def open_loop(system: System) -> Array:
    """The mean after each tick, (T, n), from x0 on without readings."""
    out = np.empty(system.b.shape)
    kernels.open_loop(system.model, system.data, system.start.x, out)
    return out


def _padded(size: int) -> int:
    return -(-size // LANES) * LANES


def _part(data: Data, ticks: slice) -> Data:
    return Data(*(a[ticks] for a in data))


def _chunks(system: System, numbers: int, budget: int) -> list[slice]:
    """All ticks, in parts of which each takes no more bytes for so many numbers a tick."""
    T, length = len(system.y), max(1, budget // (8 * numbers))
    return [slice(first, min(first + length, T)) for first in range(0, max(T, 1), length)]


def _gains(system: System, ticks: int) -> Gains:
    """Room for the gains of that many ticks."""
    m, size = system.model.H.shape
    s, e, which, count = np.empty((ticks, m)), np.empty((ticks, m)), np.empty((ticks, m), int), np.empty(ticks, int)
    return Gains(np.empty((ticks, m, size)), np.empty((ticks, m, m)), s, e, which, count)


def _adjoint(system: System) -> Adjoint:
    size = system.model.H.shape[1]
    return Adjoint(np.zeros((1, size)), np.zeros((size, size)))


def _backwards(system: System) -> Iterator[tuple[slice, States, Gains, float]]:
    """Chunks from the last to the first: ticks, all states and gains, log-likelihood."""
    m, size = system.model.H.shape
    numbers = size * size + size + m * size + 3 * m + 1
    chunks, state, one = _chunks(system, numbers, BUDGET), system.start, _gains(system, 1)
    borders = []
    for ticks in chunks:
        borders.append(States(state.x.copy(), state.P.copy()))
        if ticks is not chunks[-1]:
            kernels.forward(system.model, _part(system.data, ticks), state, one)
    room = _borrow((chunks[0].stop + 1) * numbers)
    for ticks, border in zip(reversed(chunks), reversed(borders)):
        states, gains = _divide(room, ticks.stop - ticks.start, one)
        states.x[0], states.P[0] = border.x[0], border.P[0]
        yield ticks, states, gains, float(kernels.forward(system.model, _part(system.data, ticks), states, gains))
    _rooms.append(room)


_rooms: list[Array] = []  # not in use; kept because fresh memory costs as much time as what is written to it


def _borrow(numbers: int) -> Array:
    room = _rooms.pop() if _rooms else np.empty(0)
    return room if len(room) >= numbers else np.empty(numbers)


def _divide(room: Array, ticks: int, one: Gains) -> tuple[States, Gains]:
    """States and gains of so many ticks, all within the room; what the channels tell each other is not kept."""
    m, size = one.w.shape[1:]
    shapes = (
        (ticks + 1, size, size),
        (ticks + 1, size),
        (ticks, m, size),
        (ticks, m),
        (ticks, m),
        (ticks, m),
        (ticks,),
    )
    ends = np.cumsum([np.prod(shape) for shape in shapes])
    parts = np.split(room[: ends[-1]], ends[:-1])
    P, x, w, s, e, which, count = (part.reshape(shape) for part, shape in zip(parts, shapes))
    return States(x, P), Gains(w, one.c, s, e, which.view(np.int64), count.view(np.int64))


def _is_compiled(kernel: Any) -> bool:
    """Whether numba has the code in memory, or in a file of its cache that is younger than the source."""
    if kernel.signatures:
        return True
    folder, source = kernel.stats.cache_path, Path(kernels.__file__)
    if folder is None:
        return False
    files = Path(folder).glob(f"{source.stem}.{kernel.py_func.__name__}-*.nbi")
    return any(file.stat().st_mtime >= source.stat().st_mtime for file in files)
