"""Compiled kernels of the batch engine: what is done once a tick. batch.py prepares their arrays.

Of n states the first d move, the others are constants, which may walk. W is the identity with F in its first d rows and
columns. Each tick is

    predict   x <- W x + b         P <- W P W' + Q
    fuse      L L' = H P H' + R     e = L^-1 (y - H x)     W = L^-1 H P     x <- x + W' e     P <- P - W' W
              K = W' L^-1

and the way back, for the derivative r of the log-likelihood by the state and N, minus the expectation of its second,
with H, y and R of the channels fused,

    smooth    z = x + P r     V = P - P N P
    unfuse    u = R^-1 (y - H z)     D = R^-1 - R^-1 H V H' R^-1     B = D H / 2 - R^-1 H P N
              r <- r + H' u     N <- N + H' B + B' H
    unpredict r <- W' r         N <- W' N W

(Koopman and Durbin 2000, with u and D written for the smoothed state). np.dot is the processor's own matrix product, as
long as an array lies in one piece and is not transposed. Loops are spelled out: whole arrays in one expression take
numba seconds to compile. What a tick works on is allocated once (Now, Carry): an allocation costs as much as a reading.

All kernels stay in one module: numba's cache does not notice that a compiled function of another file has changed. What
only have to be compiled here, `carried` and `followed` of state/moves.py, call none.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from estimator.batch.compiled import Function, compiled
from estimator.record import Array
from estimator.state import moves

LOG_2PI = float(np.log(2.0 * np.pi))
ROOM = (1e-200, 1e200)
HOW: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": {"contract"}}


class Model(NamedTuple):
    """What does not change from tick to tick: fields of System, F of each regime transposed too, and row o of H has its
    entries at places[start[o] : start[o + 1]]. Without a column that varies, spans are 0."""

    F: Array
    F_T: Array
    Q: Array
    H: Array
    spans: Array
    column: int
    start: Array
    places: Array


class Data(NamedTuple):
    """What changes from tick to tick: fields of System, and, both (K, m), whether to fuse a reading, and then 1 / R."""

    regime: Array
    b: Array
    y: Array
    grown: Array
    R: Array
    use: Array
    inverse: Array


class States(NamedTuple):
    """Filtered x (K + 1, n) and P (K + 1, n, n), [0] before the first tick; or just one of x, P or both, overwritten
    tick by tick."""

    x: Array
    P: Array


class Carry(NamedTuple):
    """Room for what becomes of x (d,) and of P: its first columns, these times W' (n, d) each, and W P W' (d, d)."""

    x: Array
    P: Array
    PW: Array
    WPW: Array


class Now(NamedTuple):
    """The state at one tick, x (n,) and P (n, n), and H (m, n) and H' there; room for what _fuse finds, unused channels
    with rows of the identity: H P, W (m, n), W', H P H', L (m, m), e (m,), W'W; to carry."""

    x: Array
    P: Array
    H: Array
    H_T: Array
    HP: Array
    W: Array
    W_T: Array
    HPH: Array
    L: Array
    e: Array
    WW: Array
    carry: Carry


class Backwards(NamedTuple):
    """What _unfuse finds: u (m,), D (m, m) and E = H - H P N (m, n); room for H P (m, n), P H', B (m, n), to carry."""

    u: Array
    D: Array
    E: Array
    HP: Array
    PH: Array
    B: Array
    carry: Carry


class Compared(NamedTuple):
    """Of each tick: predicted reading and its sd (K, m); gain (K, n, m), or (0, n, m) where it is not wanted; nis and
    log-likelihood (K,)."""

    predicted: Array
    sd: Array
    gain: Array
    nis: Array
    loglike: Array


class Smooth(NamedTuple):
    """Smoothed x (K, n), var (K or 0, n), cov (K or 0, n, n); reading H x of some channels and its variance, (K, k)."""

    x: Array
    var: Array
    cov: Array
    reading: Array
    reading_var: Array


class Slopes(NamedTuple):
    """Derivatives of the log-likelihood: y, R (K, m) and grown (K,) of each tick, twice that by Q of each regime."""

    y: Array
    R: Array
    grown: Array
    Q: Array


def kernel(function: Function) -> Function:
    """Compile on the first call, and keep the code."""
    return compiled(function, cache=True, **HOW)


def part(function: Function) -> Function:
    """Compile as a part of kernels, in their place: a call would hand over every field of every array."""
    return compiled(function, forceinline=True, **HOW)


@part
def _vary(model: Model, H: Array, grown: float) -> None:
    """Set the varying column of H for this tick."""
    for o in range(len(H)):
        if model.spans[o] != 0.0:
            H[o, model.column] = model.H[o, model.column] + model.spans[o] * grown


@part
def _row_dot(model: Model, H: Array, o: int, v: Array) -> float:
    """H[o] v."""
    result = 0.0
    for entry in range(model.start[o], model.start[o + 1]):
        q = model.places[entry]
        result += H[o, q] * v[q]
    return result


@part
def _row_times(model: Model, H: Array, o: int, P: Array, out: Array) -> None:
    """out = H[o] P."""
    out[:] = 0.0
    for entry in range(model.start[o], model.start[o + 1]):
        q = model.places[entry]
        h = H[o, q]
        for j in range(len(out)):
            out[j] += h * P[q, j]


@part
def _carry(M: Array, M_T: Array, x: Array, P: Array, room: Carry) -> None:
    """x <- W x and P <- W P W', W the identity with M (d, d) in its first rows and columns; P W' stays in the room."""
    d, n = len(M), len(P)
    np.dot(M, x[:d], room.x)
    for i in range(d):
        x[i] = room.x[i]
    for i in range(n):
        for j in range(d):
            room.P[i, j] = P[i, j]
    np.dot(room.P, M_T, room.PW)
    np.dot(M, room.PW[:d], room.WPW)
    for i in range(d):
        for j in range(i, d):
            P[i, j] = room.WPW[i, j]
        for j in range(i):
            P[i, j] = P[j, i]
    for i in range(d, n):
        for j in range(d):
            P[i, j] = P[j, i] = room.PW[i, j]


@part
def _room(d: int, n: int) -> Carry:
    return Carry(np.empty(d), np.empty((n, d)), np.empty((n, d)), np.empty((d, d)))


@part
def _begin(model: Model, states: States) -> Now:
    """The state before the first tick."""
    (m, n), d = model.H.shape, model.F.shape[1]
    HP, W, H_T, W_T = np.empty((m, n)), np.empty((m, n)), np.empty((n, m)), np.empty((n, m))
    room = _room(d, n)
    for o in range(m):
        for i in range(n):
            H_T[i, o] = model.H[o, i]
    x, P, HPH, L = states.x[0].copy(), states.P[0].copy(), np.empty((m, m)), np.empty((m, m))
    return Now(x, P, model.H.copy(), H_T, HP, W, W_T, HPH, L, np.empty(m), np.empty((n, n)), room)


@part
def _keep(now: Now, states: States, k: int, ticks: int) -> None:
    """Keep x and P after k of the ticks where there is room for all of them; else after the last alone."""
    n, at_x, at_P = len(now.P), k if len(states.x) > 1 else 0, k if len(states.P) > 1 else 0
    if at_x == k or k == ticks:
        for i in range(n):
            states.x[at_x, i] = now.x[i]
    if at_P == k or k == ticks:
        for i in range(n):
            for j in range(n):
                states.P[at_P, i, j] = now.P[i, j]


@part
def _predict(model: Model, data: Data, t: int, now: Now) -> None:
    """x <- W x + b and P <- W P W' + Q."""
    x, P, d, Q = now.x, now.P, model.F.shape[1], model.Q[data.regime[t]]
    _carry(model.F[data.regime[t]], model.F_T[data.regime[t]], x, P, now.carry)
    for i in range(len(P)):
        x[i] += data.b[t, i]
    for i in range(d):
        for j in range(d):
            P[i, j] += Q[i, j]
    for i in range(d, len(P)):
        P[i, i] += Q[i, i]


@part
def _any(which: Array) -> bool:
    """Whether any is True."""
    found = False
    for o in range(len(which)):
        found |= which[o]
    return found


@part
def _look(model: Model, now: Now) -> None:
    """H' of the tick, H P and H P H'."""
    for o in range(len(now.H)):
        if model.spans[o] != 0.0:
            now.H_T[model.column, o] = now.H[o, model.column]
    np.dot(now.H, now.P, now.HP)
    np.dot(now.HP, now.H_T, now.HPH)


@part
def _whiten(model: Model, data: Data, t: int, o: int, now: Now) -> float:
    """Row o of L, W and e, of a channel that is used, after those before it; its part of the determinant."""
    L, W, f = now.L, now.W, data.R[t, o] + now.HPH[o, o]
    e = data.y[t, o] - _row_dot(model, now.H, o, now.x)
    for i in range(W.shape[1]):
        W[o, i] = now.HP[o, i]
    for p in range(o):
        left = now.HPH[o, p] if data.use[t, p] else 0.0
        for k in range(p):
            left -= L[o, k] * L[p, k]
        left /= L[p, p]
        L[o, p] = left
        f -= left * left
        e -= left * now.e[p]
        for i in range(W.shape[1]):
            W[o, i] -= left * W[p, i]
    s = 1.0 / np.sqrt(f)
    L[o, o], now.e[o] = np.sqrt(f), s * e
    for i in range(W.shape[1]):
        W[o, i] *= s
    return f


@part
def _unused(o: int, now: Now) -> None:
    """Row o of L, W and e, of a channel that is not used."""
    for p in range(o):
        now.L[o, p] = 0.0
    now.L[o, o], now.e[o] = 1.0, 0.0
    for i in range(now.W.shape[1]):
        now.W[o, i] = 0.0


@part
def _fuse(model: Model, data: Data, t: int, now: Now) -> tuple[int, float, float]:
    """Update x and P by what is to be used at tick t: count, e'e, and the log-determinant of the innovations."""
    W, count, squares, logarithm = now.W, 0, 0.0, 0.0
    product = 1.0  # one logarithm for many channels, as long as their product has room
    for o in range(len(W)):
        if not data.use[t, o]:
            _unused(o, now)
            continue
        product *= _whiten(model, data, t, o, now)
        squares += now.e[o] * now.e[o]
        count += 1
        if not ROOM[0] < product < ROOM[1]:
            logarithm += np.log(product)
            product = 1.0
    if count:
        _update(now)
    return count, squares, logarithm + np.log(product)


@part
def _update(now: Now) -> None:
    """x <- x + W' e and P <- P - W' W."""
    x, P, W, n = now.x, now.P, now.W, len(now.x)
    for o in range(len(W)):
        for i in range(n):
            x[i] += W[o, i] * now.e[o]
            now.W_T[i, o] = W[o, i]
    np.dot(now.W_T, W, now.WW)
    for i in range(n):
        for j in range(n):
            P[i, j] -= now.WW[i, j]


@part
def _gain(now: Now, out: Array) -> None:
    """K = W' L^-1, (n, m); W is used up."""
    L, W = now.L, now.W
    for o in range(len(W) - 1, -1, -1):
        for k in range(o + 1, len(W)):
            if L[k, o] != 0.0:
                for i in range(W.shape[1]):
                    W[o, i] -= L[k, o] * W[k, i]
        for i in range(W.shape[1]):
            W[o, i] /= L[o, o]
            out[i, o] = W[o, i]


@kernel
def forward(model: Model, data: Data, states: States) -> float:
    """Filter; the log-likelihood of these ticks."""
    now, ticks, result = _begin(model, states), len(data.y), 0.0
    for t in range(ticks):
        _predict(model, data, t, now)
        _vary(model, now.H, data.grown[t])
        if _any(data.use[t]):
            _look(model, now)
        count, squares, logarithm = _fuse(model, data, t, now)
        _keep(now, states, t + 1, ticks)
        result -= 0.5 * (squares + logarithm + count * LOG_2PI)
    return result


@kernel
def compare(model: Model, data: Data, states: States, spread: Array, out: Compared) -> None:
    """Filter with every reading, used or not, compared first, with its sd where `spread` (K, m)."""
    now, ticks = _begin(model, states), len(data.y)
    for t in range(ticks):
        _predict(model, data, t, now)
        _vary(model, now.H, data.grown[t])
        if _any(data.use[t]) or _any(spread[t]):
            _look(model, now)
        for o in range(len(now.H)):
            out.predicted[t, o] = _row_dot(model, now.H, o, now.x)
            if spread[t, o]:
                out.sd[t, o] = np.sqrt(max(now.HPH[o, o], 0.0) + data.R[t, o])
        count, squares, logarithm = _fuse(model, data, t, now)
        if len(out.gain):
            _gain(now, out.gain[t])
        _keep(now, states, t + 1, ticks)
        out.nis[t] = squares if count else np.nan
        out.loglike[t] = -0.5 * (squares + logarithm + count * LOG_2PI)


@part
def _remainder(g: Array, C: Array) -> None:
    """C <- R^-1 - R^-1 C R^-1, with g the diagonal of R^-1."""
    for o in range(len(g)):
        for p in range(len(g)):
            C[o, p] *= -g[o] * g[p]
        C[o, o] += g[o]


@part
def _backwards(model: Model) -> Backwards:
    (m, n), d = model.H.shape, model.F.shape[1]
    E, HP, B = np.empty((m, n)), np.empty((m, n)), np.empty((m, n))
    return Backwards(np.zeros(m), np.empty((m, m)), E, HP, np.empty((n, m)), B, _room(d, n))


@part
def _unfuse(model: Model, H: Array, data: Data, t: int, z: Array, P: Array, r: Array, N: Array, out: Backwards) -> None:
    """Take r and N back over the readings of tick t, with the smoothed z and filtered P after it.

    Of channels not fused u and D are 0.
    """
    (m, n), g, D, B = H.shape, data.inverse[t], out.D, out.B
    for o in range(m):
        _row_times(model, H, o, P, out.HP[o])
        out.u[o] = g[o] * (data.y[t, o] - _row_dot(model, H, o, z)) if data.use[t, o] else 0.0
        for i in range(n):
            out.PH[i, o] = out.HP[o, i]
    np.dot(out.HP, N, B)
    for o in range(m):
        for i in range(n):
            out.E[o, i] = H[o, i] - B[o, i]
            r[i] += H[o, i] * out.u[o]
            B[o, i] *= -g[o]
    np.dot(out.E, out.PH, D)
    _remainder(g, D)
    for p in range(m):
        for entry in range(model.start[p], model.start[p + 1]):
            q = model.places[entry]
            for o in range(m):
                B[o, q] += 0.5 * D[o, p] * H[p, q]
    _add_symmetric(model, H, B, N)


@part
def _add_symmetric(model: Model, H: Array, B: Array, N: Array) -> None:
    """N <- N + H' B + B' H."""
    n = len(N)
    for i in range(n):
        for j in range(n):
            N[i, j] *= 0.5
    for o in range(len(H)):
        for entry in range(model.start[o], model.start[o + 1]):
            q = model.places[entry]
            h = H[o, q]
            for j in range(n):
                N[q, j] += h * B[o, j]
    for i in range(n):
        for j in range(i + 1):
            N[i, j] += N[j, i]
    for i in range(n):
        for j in range(i):
            N[j, i] = N[i, j]


@part
def _smooth_mean(states: States, k: int, r: Array, out: Array) -> None:
    """out = x + P r of state k."""
    np.dot(states.P[k], r, out)
    for i in range(len(out)):
        out[i] += states.x[k, i]


@part
def _smooth_covariance(P: Array, N: Array, var: Array, cov: Array) -> None:
    """V = P - P N P: its diagonal, and all of it if cov, (n, n) or (0, n), has room for it."""
    n, NP = len(P), np.dot(N, P)
    for i in range(n):
        var[i] = P[i, i]
    for i in range(n):
        for j in range(n):
            var[j] -= P[i, j] * NP[i, j]
    if len(cov):
        PNP = np.dot(P, NP)
        for i in range(n):
            for j in range(n):
                cov[i, j] = P[i, j] - 0.5 * (PNP[i, j] + PNP[j, i])


@kernel
def smooth(model: Model, data: Data, channels: Array, states: States, r: Array, N: Array, out: Smooth) -> None:
    """From the last tick to the first, after `forward` has kept all states; channels (k,): whose reading is wanted."""
    H, back = model.H.copy(), _backwards(model)
    for t in range(len(data.y) - 1, -1, -1):
        P = states.P[t + 1]
        _vary(model, H, data.grown[t])
        _smooth_mean(states, t + 1, r, out.x[t])
        if len(out.var):
            _smooth_covariance(P, N, out.var[t], out.cov[t] if len(out.cov) else P[:0])
        for k, o in enumerate(channels):
            Ph = np.dot(P, H[o])
            out.reading[t, k] = np.dot(H[o], out.x[t])
            out.reading_var[t, k] = np.dot(H[o], Ph) - np.dot(Ph, np.dot(N, Ph))
        _unfuse(model, H, data, t, out.x[t], P, r, N, back)
        _carry(model.F_T[data.regime[t]], model.F[data.regime[t]], r, N, back.carry)


@part
def _slopes_of_readings(model: Model, data: Data, t: int, z: Array, P: Array, found: Backwards, out: Slopes) -> None:
    """R = (u^2 - D) / 2, and of the column that varies H = u z - V h' / R, of what _unfuse has found at tick t."""
    u, D, E = found.u, found.D, found.E
    for o in range(len(u)):
        out.y[t, o], out.R[t, o] = -u[o], 0.5 * (u[o] * u[o] - D[o, o])
        if data.use[t, o] and model.spans[o] != 0.0:
            Vh = np.dot(P[model.column], E[o])
            out.grown[t] += model.spans[o] * (u[o] * z[model.column] - data.inverse[t, o] * Vh)


@kernel
def score(model: Model, data: Data, states: States, r: Array, N: Array, out: Slopes) -> None:
    """From the last tick to the first, after `forward` has kept all states: Q += r r' - N."""
    H, z, back = model.H.copy(), np.empty_like(r), _backwards(model)
    for t in range(len(data.y) - 1, -1, -1):
        Q = out.Q[data.regime[t]]
        _vary(model, H, data.grown[t])
        _smooth_mean(states, t + 1, r, z)
        _unfuse(model, H, data, t, z, states.P[t + 1], r, N, back)
        _slopes_of_readings(model, data, t, z, states.P[t + 1], back, out)
        for i in range(len(r)):
            for j in range(len(r)):
                Q[i, j] += r[i] * r[j] - N[i, j]
        _carry(model.F_T[data.regime[t]], model.F[data.regime[t]], r, N, back.carry)


@kernel
def _coast(F_T: Array, regime: Array, b: Array, start: Array) -> Array:
    out, x = np.empty_like(b), start
    for t in range(len(b)):
        np.dot(x, F_T[regime[t]], out[t])
        x = out[t]
        for k in range(x.shape[0]):
            for i in range(x.shape[1]):
                x[k, i] += b[t, k, i]
    return out


def coast(F: Array, regime: Array, b: Array, start: Array) -> Array:
    """x (..., T, n): x[t] = F[regime[t]] x[t - 1] + b[t] from `start` (..., n) on; F (R, n, n), regime (T,).

    b (..., T, n); of several runs the step of a tick is one product of matrices.
    """
    F_T, regime = _of_kind((F.transpose(0, 2, 1), regime))
    return _in_order(lambda b, start: _coast(F_T, regime, b, start), b, start)


@kernel
def _remember(keep: Array, b: Array, start: Array) -> Array:
    out, x = np.empty_like(b), start
    for t in range(len(b)):
        for k in range(x.shape[0]):
            for i in range(x.shape[1]):
                out[t, k, i] = keep[i] * x[k, i] + b[t, k, i]
        x = out[t]
    return out


def remember(keep: Array, b: Array, start: Array) -> Array:
    """x (..., T, m): x[t] = keep x[t - 1] + b[t] from `start` (..., m) on, each by its own keep (m,); b (..., T, m)."""
    keep = np.require(keep, np.float64, ["C", "W"])
    return _in_order(lambda b, start: _remember(keep, b, start), b, start)


def _in_order(run: Callable[[Array, Array], Array], b: Array, start: Array) -> Array:
    """A run over b (..., T, n) from `start` (..., n) on, as a kernel takes both: (T, k, n) and (k, n)."""
    ticks, n = b.shape[-2:]
    side_by_side = np.moveaxis(b, -2, 0).reshape(ticks, -1, n)
    b_, start_ = (np.require(each, np.float64, ["C", "W"]) for each in (side_by_side, start.reshape(-1, n)))
    return np.moveaxis(run(b_, start_).reshape(ticks, *b.shape[:-2], n), 0, -2)


_carried, _followed = kernel(moves.carried), kernel(moves.followed)


def carried(*arrays: Array) -> moves.Carried:
    """What `moves.carried` does, compiled."""
    done: moves.Carried = _carried(*_of_kind(arrays))
    return done


def followed(*arrays: Array) -> Array:
    """What `moves.followed` does, compiled."""
    return np.asarray(_followed(*_of_kind(arrays)))


def _of_kind(arrays: tuple[Array, ...]) -> list[Array]:
    """Arrays as a kernel takes them; the second says in which regime each tick is."""
    regime = 1
    kinds = [np.int64 if k == regime else np.float64 for k in range(len(arrays))]
    return [np.require(a, kind, ["C", "W"]) for a, kind in zip(arrays, kinds, strict=True)]
