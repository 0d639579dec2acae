"""Compiled kernels of the batch engine: what is done once a tick. batch.py prepares their arrays.

The n states are padded to N, a multiple of LANES, and ordered so that the first D of them, also a multiple of LANES,
hold all that move; padding has no variance and touches nothing. Each tick is

    predict   x <- F x + b         P_dd <- F P_dd F' + Q_dd     P_dc <- F P_dc     P_cc <- P_cc + Q_cc
    fuse      one channel after the other, h its row of H:
              s = 1 / sqrt(h P h' + R)     e = s (y - h x)     w = s P h'     x <- x + w e     P <- P - w w'

and the way back, for the derivative r of the log-likelihood by the state and N, minus the expectation of its second,

    unfuse    u = s (e - w r)     D = s^2 (1 + w N w)     r <- r + h' u     N <- N - h z' - z h',  z = s N w - h D / 2
    unpredict r <- F' r           N <- F' N F

(Koopman and Durbin 2000, scaled by s). A vector is a row of an array of two dimensions, for lanes are read from those.

All kernels stay in one module: numba's cache does not notice that a compiled function of another file has changed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple, TypeVar

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import njit
from numba.core import cgutils, types
from numba.extending import intrinsic, models, register_jitable, register_model

from estimator.record import Array

LANES = 8  # float64 of one register; narrower processors take two or four for it
GRAM_ROWS = 48  # whitened innovations gathered before they are multiplied
LOG_2PI = float(np.log(2.0 * np.pi))
TINY, HUGE = 1e-100, 1e100  # a running product of variances is taken the logarithm of before it leaves this range

Function = TypeVar("Function", bound=Callable[..., Any])


class Model(NamedTuple):
    """What does not change from tick to tick.

    F, FT   (R, D, D)  transition of what moves and its transpose: x_d <- F x_d
    Q       (R, N, N)  what each tick adds to the covariance
    H       (m, N)     rows of the channels
    start   (m + 1,)   row o has its entries at places[start[o] : start[o + 1]]
    places  (entries,)
    first   (m + 1,)   and they lie in the lanes that begin at lanes[first[o] : first[o + 1]]
    lanes   (pieces,)
    column  of H that varies, -1: none: H[o, column] + spans[o] * grown
    spans   (m,)
    """

    F: Array
    FT: Array
    Q: Array
    H: Array
    start: Array
    places: Array
    first: Array
    lanes: Array
    column: int
    spans: Array


class Data(NamedTuple):
    """What changes from tick to tick.

    regime    (K,)
    b         (K, n)
    y         (K, m)  reading
    use       (K, m)  whether to fuse it
    variance  (K, m)
    grown     (K,)
    """

    regime: Array
    b: Array
    y: Array
    use: Array
    variance: Array
    grown: Array


class States(NamedTuple):
    """Filtered x (K + 1, N) and P (K + 1, N, N), [0] before the first tick; or just one, overwritten tick by tick."""

    x: Array
    P: Array


class Gains(NamedTuple):
    """Of the channels fused at a tick, in this order; each array for K ticks, or for one, overwritten tick by tick.

    w      (K, m, N)  gain times 1 / s
    c      (K, m, m)  c[p, q] = -h_p w_q, q before p: what e_q tells channel p
    s      (K, m)     1 / sd of the innovation, given the channels before
    e      (K, m)     the innovation times s
    which  (K, m)     the channel
    used   (K,)       how many there are
    """

    w: Array
    c: Array
    s: Array
    e: Array
    which: Array
    used: Array


class Compared(NamedTuple):
    """Of each tick: predicted reading and its sd, what was fused (K, m); nis and log-likelihood (K,)."""

    predicted: Array
    sd: Array
    fused: Array
    nis: Array
    loglike: Array


class Adjoint(NamedTuple):
    """r (1, N) and N (N, N), carried from chunk to chunk, later to earlier."""

    r: Array
    N: Array


class Smooth(NamedTuple):
    """Smoothed x, var (K, n), cov (K or 0, n, n), r (K, n); weights along (k, N) of r with their results (K, k)."""

    x: Array
    var: Array
    cov: Array
    r: Array
    along: Array
    along_r: Array
    along_N: Array


class Slopes(NamedTuple):
    """Derivatives of the log-likelihood.

    b, y, R, grown  (K, n), (K, m), (K, m), (K,), of each tick
    F, Q, H         sums, padded as in Model; Q twice
    """

    b: Array
    y: Array
    R: Array
    grown: Array
    F: Array
    Q: Array
    H: Array


# Lanes: LANES numbers next to each other in a row. Block: LANES rows of lanes, a square piece of a matrix in registers.
# They are spelled out because a compiler cannot know that two arrays do not overlap, nor that their rows are short.


class _Lanes(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Lanes")


_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_LANES = _Lanes()
_BLOCK = types.UniTuple(_LANES, LANES)  # type: ignore[no-untyped-call]


@register_model(_Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)  # type: ignore[no-untyped-call]


def _address(context: Any, builder: Any, kind: Any, array: Any, i: Any, j: Any) -> Any:
    fields = context.make_array(kind)(context, builder, value=array)
    across = cgutils.unpack_tuple(builder, fields.shape)[-1]  # type: ignore[no-untyped-call]
    return builder.gep(fields.data, [builder.add(builder.mul(i, across), j)])


def _place(context: Any, builder: Any, kind: Any, array: Any, i: Any, j: Any) -> Any:
    return builder.bitcast(_address(context, builder, kind, array, i, j), _VECTOR.as_pointer())


def _onwards(builder: Any, i: Any) -> list[Any]:
    return [builder.add(i, ir.Constant(i.type, r)) for r in range(LANES)]


def _spread(builder: Any, number: Any) -> Any:
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    first = builder.insert_element(nothing, number, ir.IntType(32)(0))
    return builder.shuffle_vector(first, nothing, ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES))


def _muladd(builder: Any, a: Any, b: Any, c: Any) -> Any:
    kind, name = ir.FunctionType(_VECTOR, [_VECTOR] * 3), f"llvm.fmuladd.v{LANES}f64"
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), (a, b, c))  # type: ignore[no-untyped-call]


def _split(builder: Any, block: Any) -> list[Any]:
    return [builder.extract_value(block, r) for r in range(LANES)]


def _join(context: Any, builder: Any, rows: list[Any]) -> Any:
    return context.make_tuple(builder, _BLOCK, rows)


def _shuffle(builder: Any, a: Any, b: Any, order: list[int]) -> Any:
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(ir.IntType(32), len(order)), order))


def lanewise(function: Callable[..., Any]) -> Any:
    """An operation on lanes or blocks: signature, and how to write it in the compiler's own language."""
    return intrinsic(function)


@lanewise
def load(_: Any, array: Any, i: Any, j: Any) -> Any:
    """Lanes array[i, j : j + LANES]."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.load(_place(context, builder, signature.args[0], *args), align=8)

    return _LANES(array, types.intp, types.intp), generate


@lanewise
def store(_: Any, array: Any, i: Any, j: Any, lanes: Any) -> Any:
    """array[i, j : j + LANES] = lanes."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        builder.store(args[3], _place(context, builder, signature.args[0], *args[:3]), align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, types.intp, _LANES), generate


@lanewise
def spread(_: Any, number: Any) -> Any:
    """Lanes that all hold the number."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _spread(builder, args[0])

    return _LANES(types.float64), generate


@lanewise
def at(_: Any, array: Any, i: Any, j: Any) -> Any:
    """array[i, j], which must not be negative."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.load(_address(context, builder, signature.args[0], *args))

    return array.dtype(array, types.intp, types.intp), generate


@lanewise
def muladd(_: Any, a: Any, b: Any, c: Any) -> Any:
    """Lanes a b + c."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _muladd(builder, *args)

    return _LANES(_LANES, _LANES, _LANES), generate


@lanewise
def total(_: Any, lanes: Any) -> Any:
    """Sum of the lanes."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        part = args[0]
        half = LANES // 2
        while half:
            low, high = list(range(half)), list(range(half, 2 * half))
            part = builder.fadd(_shuffle(builder, part, part, low), _shuffle(builder, part, part, high))
            half //= 2
        return builder.extract_element(part, ir.IntType(32)(0))

    return types.float64(_LANES), generate


@lanewise
def zeros(_: Any) -> Any:
    """A block of zeros."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _join(context, builder, [ir.Constant(_VECTOR, [0.0] * LANES)] * LANES)

    return _BLOCK(), generate


def _outer(context: Any, builder: Any, kind: Any, block: Any, array: Any, places: list[Any], lanes: Any) -> Any:
    """The block plus, in each row, the lanes times the number at the row's place."""
    rows = []
    for row, (i, j) in zip(_split(builder, block), places):
        number = builder.load(_address(context, builder, kind, array, i, j))
        rows.append(_muladd(builder, _spread(builder, number), lanes, row))
    return _join(context, builder, rows)


@lanewise
def down(_: Any, block: Any, array: Any, i: Any, k: Any, lanes: Any) -> Any:
    """The block plus array[i : i + LANES, k] times the lanes: a step of array @ other."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        block, array, i, k, lanes = args
        places = [(here, k) for here in _onwards(builder, i)]
        return _outer(context, builder, signature.args[1], block, array, places, lanes)

    return _BLOCK(_BLOCK, array, types.intp, types.intp, _LANES), generate


@lanewise
def across(_: Any, block: Any, array: Any, k: Any, i: Any, lanes: Any) -> Any:
    """The block plus array[k, i : i + LANES] times the lanes: a step of array.T @ other."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        block, array, k, i, lanes = args
        places = [(k, here) for here in _onwards(builder, i)]
        return _outer(context, builder, signature.args[1], block, array, places, lanes)

    return _BLOCK(_BLOCK, array, types.intp, types.intp, _LANES), generate


@lanewise
def get(_: Any, array: Any, i: Any, j: Any) -> Any:
    """The block array[i : i + LANES, j : j + LANES]."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        array, i, j = args
        places = [_place(context, builder, signature.args[0], array, here, j) for here in _onwards(builder, i)]
        return _join(context, builder, [builder.load(place, align=8) for place in places])

    return _BLOCK(array, types.intp, types.intp), generate


@lanewise
def put(_: Any, array: Any, i: Any, j: Any, block: Any) -> Any:
    """array[i : i + LANES, j : j + LANES] = block."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        array, i, j, block = args
        for row, here in zip(_split(builder, block), _onwards(builder, i)):
            builder.store(row, _place(context, builder, signature.args[0], array, here, j), align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, types.intp, _BLOCK), generate


@lanewise
def plus(_: Any, block: Any, factor: Any, other: Any) -> Any:
    """The block plus the factor times the other block."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        factor = _spread(builder, args[1])
        pairs = zip(_split(builder, args[0]), _split(builder, args[2]))
        return _join(context, builder, [_muladd(builder, factor, theirs, ours) for ours, theirs in pairs])

    return _BLOCK(_BLOCK, types.float64, _BLOCK), generate


@lanewise
def weigh(_: Any, block: Any, other: Any, lanes: Any) -> Any:
    """The lanes plus the products of the blocks' entries, summed down each column."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        result = args[2]
        for ours, theirs in zip(_split(builder, args[0]), _split(builder, args[1])):
            result = _muladd(builder, ours, theirs, result)
        return result

    return _LANES(_BLOCK, _BLOCK, _LANES), generate


@lanewise
def turn(_: Any, block: Any) -> Any:
    """The block transposed: halves, quarters and single entries change places."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        rows = _split(builder, args[0])
        step = LANES // 2
        while step:
            low = [k if not k & step else LANES + k - step for k in range(LANES)]
            high = [k + step if not k & step else LANES + k for k in range(LANES)]
            for r in range(LANES):
                if not r & step:
                    a, b = rows[r], rows[r + step]
                    rows[r], rows[r + step] = _shuffle(builder, a, b, low), _shuffle(builder, a, b, high)
            step //= 2
        return _join(context, builder, rows)

    return _BLOCK(_BLOCK), generate


_HOW = {"fastmath": {"contract"}, "error_model": "numpy"}
_compiled: Any = partial(njit, nogil=True, no_cfunc_wrapper=True, **_HOW)
_compiled_in: Any = partial(register_jitable, forceinline=True, **_HOW)


def kernel(function: Function) -> Function:
    """Compile on the first call, and keep the code where there is a place for it (not in a read-only install)."""
    try:
        return _compiled(cache=True)(function)
    except RuntimeError:
        return _compiled()(function)


def piece(function: Function) -> Function:
    """A part of kernels, compiled into them."""
    return _compiled_in()(function)


@piece
def _product(before: Any, A: Array, i: int, B: Array, j: int, inner: int) -> Any:
    """The block before plus that at (i, j) of A[:, :inner] @ B[:inner]."""
    for k in range(inner):
        before = down(before, A, i, k, load(B, k, j))
    return before


@piece
def _product_T(before: Any, A: Array, i: int, B: Array, j: int, inner: int) -> Any:
    """The block before plus that at (i, j) of A[:inner].T @ B[:inner]."""
    for k in range(inner):
        before = across(before, A, k, i, load(B, k, j))
    return before


@piece
def _settle(P: Array, i: int, j: int, block: Any) -> None:
    """Write a block of a symmetric matrix, i <= j, to both its places."""
    if i == j:
        half = plus(zeros(), 0.5, block)
        put(P, i, j, plus(half, 0.5, turn(block)))
    else:
        put(P, i, j, block)
        put(P, j, i, turn(block))


@piece
def _combine(A: Array, v: Array, row: int, out: Array, to: int, inner: int, width: int) -> None:
    """out[to, :width] = v[row, :inner] @ A[:inner, :width], inner even."""
    for j in range(0, width, LANES):
        even, odd = spread(0.0), spread(0.0)
        for k in range(0, inner, 2):
            even = muladd(spread(at(v, row, k)), load(A, k, j), even)
            odd = muladd(spread(at(v, row, k + 1)), load(A, k + 1, j), odd)
        store(out, to, j, muladd(spread(1.0), even, odd))


@piece
def _dot(a: Array, i: int, b: Array, j: int, width: int) -> float:
    """a[i, :width] @ b[j, :width]."""
    result = spread(0.0)
    for k in range(0, width, LANES):
        result = muladd(load(a, i, k), load(b, j, k), result)
    return total(result)


@piece
def _copy(a: Array, i: int, b: Array, j: int, width: int) -> None:
    """b[j, :width] = a[i, :width]."""
    for k in range(0, width, LANES):
        store(b, j, k, load(a, i, k))


@piece
def _add(a: Array, i: int, b: Array, j: int, width: int) -> None:
    """b[j, :width] += a[i, :width] of any width."""
    whole = width - width % LANES
    for k in range(0, whole, LANES):
        store(b, j, k, muladd(spread(1.0), load(a, i, k), load(b, j, k)))
    for k in range(whole, width):
        b[j, k] += a[i, k]


@piece
def _vary(model: Model, H: Array, grown: float) -> None:
    """Set the varying column of H for this tick."""
    if model.column >= 0:
        for o in range(len(H)):
            H[o, model.column] = model.H[o, model.column] + model.spans[o] * grown


@piece
def _move(model: Model, data: Data, t: int, x: Array, old: int, new: int, work: Array) -> None:
    """x[new] = F x[old] + b."""
    FT = model.FT[data.regime[t]]
    moving, size = len(FT), x.shape[1]
    _combine(FT, x, old, work, 0, moving, moving)
    for k in range(moving, size, LANES):
        store(work, 0, k, load(x, old, k))
    _copy(work, 0, x, new, size)
    _add(data.b, t, x, new, data.b.shape[1])


@piece
def _spread_out(model: Model, regime: int, old: Array, new: Array, G: Array) -> None:
    """new = F old F' + Q. G: room for old F'."""
    F, FT, Q = model.F[regime], model.FT[regime], model.Q[regime]
    moving, size = len(F), len(old)
    for i in range(0, size, LANES):
        for j in range(0, moving, LANES):
            put(G, i, j, _product(zeros(), old, i, FT, j, moving))
    for i in range(0, moving, LANES):
        for j in range(i, moving, LANES):
            _settle(new, i, j, _product(get(Q, i, j), F, i, G, j, moving))
    for i in range(moving, size, LANES):
        for j in range(0, moving, LANES):
            _settle(new, j, i, turn(get(G, i, j)))
        for j in range(moving, size, LANES):
            put(new, i, j, plus(get(old, i, j), 1.0, get(Q, i, j)))


@piece
def _row_times(model: Model, H: Array, o: int, P: Array, out: Array, to: int) -> None:
    """out[to] = H[o] P."""
    for j in range(0, P.shape[1], LANES):
        result = spread(0.0)
        for entry in range(model.start[o], model.start[o + 1]):
            q = model.places[entry]
            result = muladd(spread(at(H, o, q)), load(P, q, j), result)
        store(out, to, j, result)


@piece
def _row_dot(model: Model, H: Array, o: int, v: Array, row: int) -> float:
    """H[o] @ v[row]."""
    result = 0.0
    for entry in range(model.start[o], model.start[o + 1]):
        q = model.places[entry]
        result += at(H, o, q) * at(v, row, q)
    return result


@piece
def _fuse(model: Model, H: Array, data: Data, use: Array, t: int, x: Array, to: int, P: Array,
          gains: Gains) -> tuple[int, float, float]:  # fmt: skip
    """Update x[to] and P by what is to be used at tick t: count, e'e, and the log-determinant of the innovations.

    P is touched once, after all channels: until then w of a channel is corrected for those before.
    """
    k, size = min(t, len(gains.w) - 1), len(P)
    w, c = gains.w[k], gains.c[min(t, len(gains.c) - 1)]
    count, squares, determinant, logarithm = 0, 0.0, 1.0, 0.0
    for o in range(len(H)):
        if not use[t, o]:
            continue
        v = data.y[t, o] - _row_dot(model, H, o, x, to)
        _row_times(model, H, o, P, w, count)
        for p in range(count):
            c[count, p] = -_row_dot(model, H, o, w, p)
        for j in range(0, size, LANES):
            wide = load(w, count, j)
            for p in range(count):
                wide = muladd(spread(at(c, count, p)), load(w, p, j), wide)
            store(w, count, j, wide)
        f = data.variance[t, o] + _row_dot(model, H, o, w, count)
        s = 1.0 / np.sqrt(f)
        e = s * v
        for j in range(0, size, LANES):
            wide = muladd(load(w, count, j), spread(s), spread(0.0))
            store(w, count, j, wide)
            store(x, to, j, muladd(wide, spread(e), load(x, to, j)))
        gains.s[k, count], gains.e[k, count], gains.which[k, count] = s, e, o
        squares += e * e
        determinant *= f
        if determinant < TINY or determinant > HUGE:
            logarithm, determinant = logarithm + np.log(determinant), 1.0
        count += 1
    gains.used[k] = count
    for i in range(0, size, LANES):
        for j in range(i, size, LANES):
            _settle(P, i, j, plus(get(P, i, j), -1.0, _product_T(zeros(), w, i, w, j, count)))
    return count, squares, logarithm + np.log(determinant)


@kernel
def forward(model: Model, data: Data, states: States, gains: Gains) -> float:
    """Filter; the log-likelihood of these ticks."""
    H, last = model.H.copy(), len(states.x) - 1
    work, G = np.empty((1, H.shape[1])), np.empty((H.shape[1], model.F.shape[1]))
    result = 0.0
    for t in range(len(data.y)):
        old, new = min(t, last), min(t + 1, last)
        P = states.P[new]
        _vary(model, H, data.grown[t])
        _move(model, data, t, states.x, old, new, work)
        _spread_out(model, data.regime[t], states.P[old], P, G)
        count, squares, logarithm = _fuse(model, H, data, data.use, t, states.x, new, P, gains)
        result -= 0.5 * (squares + logarithm + count * LOG_2PI)
    return result


@kernel
def compare(model: Model, data: Data, limit: float, stubborn: int, wild: Array, states: States, gains: Gains,
            out: Compared) -> None:  # fmt: skip
    """Filter with every reading, used or not, compared first: one beyond `limit` sd is not fused.

    wild  (m,) ticks for which each channel has been so; for more than `stubborn`, it is believed. Changed.
    """
    H = model.H.copy()
    work, G = np.empty((1, H.shape[1])), np.empty((H.shape[1], model.F.shape[1]))
    for t in range(len(data.y)):
        P = states.P[t + 1]
        _vary(model, H, data.grown[t])
        _move(model, data, t, states.x, t, t + 1, work)
        _spread_out(model, data.regime[t], states.P[t], P, G)
        for o in range(len(H)):
            predicted = _row_dot(model, H, o, states.x, t + 1)
            _row_times(model, H, o, P, work, 0)
            sd = np.sqrt(max(_row_dot(model, H, o, work, 0), 0.0) + data.variance[t, o])
            wild[o] = wild[o] + 1 if abs(data.y[t, o] - predicted) > limit * sd else 0
            out.predicted[t, o], out.sd[t, o] = predicted, sd
            out.fused[t, o] = data.use[t, o] and (wild[o] == 0 or wild[o] > stubborn)
        count, squares, logarithm = _fuse(model, H, data, out.fused, t, states.x, t + 1, P, gains)
        out.nis[t] = squares if count else np.nan
        out.loglike[t] = -0.5 * (squares + logarithm + count * LOG_2PI)


@piece
def _unfuse(model: Model, H: Array, gains: Gains, k: int, p: int, r: Array, N: Array,
            z: Array) -> tuple[float, float]:  # fmt: skip
    """Take r and N back over channel p of tick k: u and D."""
    w, s, o, size = gains.w[k], gains.s[k, p], gains.which[k, p], len(N)
    _combine(N, w, p, z, 0, size, size)
    u = s * (gains.e[k, p] - _dot(w, p, r, 0, size))
    D = s * s * (1.0 + _dot(w, p, z, 0, size))
    for j in range(0, size, LANES):
        h = load(H, o, j)
        store(r, 0, j, muladd(h, spread(u), load(r, 0, j)))
        store(z, 0, j, muladd(load(z, 0, j), spread(-s), muladd(h, spread(0.5 * D), spread(0.0))))
    for entry in range(model.start[o], model.start[o + 1]):
        q = model.places[entry]
        h = spread(at(H, o, q))
        for j in range(0, size, LANES):
            store(N, q, j, muladd(h, load(z, 0, j), load(N, q, j)))
    for piece in range(model.first[o], model.first[o + 1]):
        j = model.lanes[piece]
        h = load(H, o, j)
        for i in range(size):
            store(N, i, j, muladd(h, spread(at(z, 0, i)), load(N, i, j)))
    return u, D


@piece
def _unpredict(model: Model, regime: int, r: Array, N: Array, Z: Array, work: Array) -> None:
    """r <- F' r and N <- F' N F; Z (N, N) is left holding N F in its first D rows."""
    F = model.F[regime]
    moving, size = len(F), len(N)
    _combine(F, r, 0, work, 0, moving, moving)
    _copy(work, 0, r, 0, moving)
    for i in range(0, size, LANES):
        for j in range(0, moving, LANES):
            put(Z, i, j, _product(zeros(), N, i, F, j, moving))
    for i in range(0, moving, LANES):
        for j in range(i, moving, LANES):
            _settle(N, i, j, _product_T(zeros(), F, i, Z, j, moving))
    for i in range(moving, size, LANES):
        for j in range(0, moving, LANES):
            put(Z, j, i, get(N, j, i))
            _settle(N, j, i, turn(get(Z, i, j)))


@piece
def _smooth_mean(x: Array, P: Array, k: int, r: Array, out: Array, work: Array) -> None:
    """out = x + P r of state k."""
    size = len(P)
    _combine(P, r, 0, work, 0, size, size)
    for j in range(0, size, LANES):
        store(out, 0, j, muladd(spread(1.0), load(work, 0, j), load(x, k, j)))


@piece
def _smooth_variance(P: Array, N: Array, out: Array) -> None:
    """out (1, N) = diagonal of P - P N P."""
    size = len(P)
    for j in range(0, size, LANES):
        result = spread(0.0)
        for i in range(0, size, LANES):
            result = weigh(_product(zeros(), N, i, P, j, size), get(P, i, j), result)
        store(out, 0, j, result)
    for i in range(size):
        out[0, i] = P[i, i] - out[0, i]


@piece
def _smooth_covariance(P: Array, N: Array, V: Array, Z: Array) -> None:
    """V = P - P N P. Z: room for N P."""
    size = len(P)
    for i in range(0, size, LANES):
        for j in range(0, size, LANES):
            put(Z, i, j, _product(zeros(), N, i, P, j, size))
    for i in range(0, size, LANES):
        for j in range(i, size, LANES):
            _settle(V, i, j, plus(get(P, i, j), -1.0, _product(zeros(), P, i, Z, j, size)))


@kernel
def smooth(model: Model, data: Data, states: States, gains: Gains, adjoint: Adjoint, out: Smooth) -> None:
    """From the last tick to the first, after `forward` has kept all states and gains."""
    H, size, n = model.H.copy(), model.H.shape[1], out.x.shape[1]
    r, N = adjoint.r, adjoint.N
    x, z, work = np.empty((1, size)), np.empty((1, size)), np.empty((1, size))
    V, Z = np.empty((size, size)), np.empty((size, size))
    for t in range(len(data.y) - 1, -1, -1):
        P = states.P[t + 1]
        _vary(model, H, data.grown[t])
        _smooth_mean(states.x, P, t + 1, r, x, work)
        _smooth_variance(P, N, z)
        if len(out.cov):
            _smooth_covariance(P, N, V, Z)
            for i in range(n):
                for j in range(n):
                    out.cov[t, i, j] = V[i, j]
        for i in range(n):
            out.x[t, i], out.var[t, i] = x[0, i], z[0, i]
        for p in range(gains.used[t] - 1, -1, -1):
            _unfuse(model, H, gains, t, p, r, N, z)
        for i in range(n):
            out.r[t, i] = r[0, i]
        for i in range(len(out.along)):
            _combine(N, out.along, i, z, 0, size, size)
            out.along_r[t, i] = _dot(out.along, i, r, 0, size)
            out.along_N[t, i] = _dot(out.along, i, z, 0, size)
        _unpredict(model, data.regime[t], r, N, Z, work)


@piece
def _slopes_of_rows(model: Model, H: Array, data: Data, t: int, rows: Array, x: Array, P: Array, N: Array,
                    out: Slopes, vectors: Array) -> None:  # fmt: skip
    """Add u x - V h / R of the wanted channels, with the smoothed x and V = P - P N P; r and N not yet unfused.

    u = (y - h x) / R.
    """
    size = len(P)
    for o in range(len(H)):
        if not (data.use[t, o] and (rows[o] or model.spans[o] != 0.0)):
            continue
        _row_times(model, H, o, P, vectors, 0)
        _combine(N, vectors, 0, vectors, 1, size, size)
        _combine(P, vectors, 1, vectors, 2, size, size)
        inverse = 1.0 / data.variance[t, o]
        u = inverse * (data.y[t, o] - _row_dot(model, H, o, x, 0))
        for j in range(0, size, LANES):
            slope = muladd(load(vectors, 2, j), spread(inverse), spread(0.0))
            slope = muladd(load(vectors, 0, j), spread(-inverse), slope)
            store(vectors, 3, j, muladd(load(x, 0, j), spread(u), slope))
        if model.column >= 0:
            out.grown[t] += model.spans[o] * vectors[3, model.column]
        if rows[o]:
            for i in range(size):
                out.H[o, i] += vectors[3, i]


@piece
def _slopes_of_noise(Q: Array, r: Array, N: Array) -> None:
    """Q += r r' - N."""
    for i in range(0, len(N), LANES):
        for j in range(0, len(N), LANES):
            put(Q, i, j, across(plus(get(Q, i, j), -1.0, get(N, i, j)), r, 0, i, load(r, 0, j)))


@piece
def _slopes_of_transition(F: Array, r: Array, x: Array, Z: Array, P: Array) -> None:
    """F += r x' - Z' P, with the adjoint r after the transition, the smoothed x and filtered P before, Z = N F."""
    moving, size = len(F), len(P)
    for i in range(0, moving, LANES):
        for j in range(0, moving, LANES):
            before = across(get(F, i, j), r, 0, i, load(x, 0, j))
            put(F, i, j, plus(before, -1.0, _product(zeros(), Z, i, P, j, size)))


@kernel
def score(model: Model, data: Data, rows: Array, states: States, gains: Gains, adjoint: Adjoint, out: Slopes) -> None:
    """From the last tick to the first, after `forward` has kept all states and gains; rows (m,): whose H is wanted."""
    H, size, n = model.H.copy(), model.H.shape[1], out.b.shape[1]
    r, N = adjoint.r, adjoint.N
    x, z, work, after = np.empty((1, size)), np.empty((1, size)), np.empty((1, size)), np.empty((1, size))
    vectors, Z = np.empty((4, size)), np.empty((size, size))
    last = len(data.y)
    _smooth_mean(states.x, states.P[last], last, r, x, work)
    for t in range(last - 1, -1, -1):
        regime = data.regime[t]
        _vary(model, H, data.grown[t])
        _slopes_of_rows(model, H, data, t, rows, x, states.P[t + 1], N, out, vectors)
        for p in range(gains.used[t] - 1, -1, -1):
            u, D = _unfuse(model, H, gains, t, p, r, N, z)
            o = gains.which[t, p]
            out.y[t, o], out.R[t, o] = -u, 0.5 * (u * u - D)
        for i in range(n):
            out.b[t, i] = r[0, i]
        _slopes_of_noise(out.Q[regime], r, N)
        _copy(r, 0, after, 0, size)
        _unpredict(model, regime, r, N, Z, work)
        _smooth_mean(states.x, states.P[t], t, r, x, work)
        _slopes_of_transition(out.F[regime], after, x, Z, states.P[t])


@piece
def _whiten(model: Model, H: Array, gains: Gains, t: int, Y: Array, E: Array) -> None:
    """E[p] <- (E[p] + h_p Y - what the channels before p have told) s_p, for the channels p fused at tick t."""
    c = gains.c[t]
    for p in range(gains.used[t]):
        o = gains.which[t, p]
        for j in range(0, E.shape[1], LANES):
            result = load(E, p, j)
            for entry in range(model.start[o], model.start[o + 1]):
                q = model.places[entry]
                result = muladd(spread(at(H, o, q)), load(Y, q, j), result)
            for q in range(p):
                result = muladd(spread(at(c, p, q)), load(E, q, j), result)
            store(E, p, j, muladd(result, spread(gains.s[t, p]), spread(0.0)))


@piece
def _gather(G: Array, E: Array, rows: int) -> None:
    """G += E' E of the first rows, in the blocks on and above the diagonal."""
    for i in range(0, len(G), LANES):
        for j in range(i, len(G), LANES):
            put(G, i, j, _product_T(get(G, i, j), E, i, E, j, rows))


@kernel
def columns(model: Model, data: Data, B: Array, D: Array, block: Array, gains: Gains, X: Array, G: Array) -> None:
    """Take k effects through the filter, after `forward` has kept the gains, and add to the Gram matrix of each block.

    B  (K, n, k)       what each adds to b
    D  (K, m, k)       what each adds to the reading
    X  (N, C)          its filtered state, C > k a multiple of LANES. Changed
    G  (blocks, C, C)  column k belongs to the data. Changed, in the blocks of lanes on and above the diagonal
    """
    H, k, n, size, width = model.H.copy(), B.shape[2], B.shape[1], len(X), X.shape[1]
    Y, E, filled = np.zeros((size, width)), np.zeros((max(GRAM_ROWS, len(H)), width)), 0
    for t in range(len(B)):
        F, w, count = model.F[data.regime[t]], gains.w[t], gains.used[t]
        if filled and (filled + count > len(E) or block[t] != block[t - 1]):
            _gather(G[block[t - 1]], E, filled)
            filled = 0
        _vary(model, H, data.grown[t])
        for j in range(0, width, LANES):
            for i in range(0, len(F), LANES):
                put(Y, i, j, _product(zeros(), F, i, X, j, len(F)))
            for i in range(len(F), size, LANES):
                put(Y, i, j, get(X, i, j))
        for i in range(n):
            _add(B[t], i, Y, i, k)
        here = E[filled:]
        for p in range(count):
            for j in range(0, width, LANES):
                store(here, p, j, spread(0.0))
            _add(D[t], gains.which[t, p], here, p, k)
        _whiten(model, H, gains, t, Y, here)
        for i in range(0, size, LANES):
            for j in range(0, width, LANES):
                put(X, i, j, plus(get(Y, i, j), -1.0, _product_T(zeros(), w, i, here, j, count)))
        for p in range(count):
            here[p, k] = gains.e[t, p]
        filled += count
    if filled:
        _gather(G[block[-1]], E, filled)


@kernel
def open_loop(model: Model, data: Data, x: Array, out: Array) -> None:
    """out (K, n): the mean after each tick, without readings. x (1, N): the one before. Changed."""
    work = np.empty((1, x.shape[1]))
    for t in range(len(out)):
        _move(model, data, t, x, 0, 0, work)
        for i in range(out.shape[1]):
            out[t, i] = x[0, i]


@kernel
def ahead(model: Model, data: Data, starts: Array, steps: int, x: Array, out: Array) -> None:
    """out (S, m): H x some ticks after each start, without readings. x (S, N): the mean at the start. Changed."""
    H, work = model.H.copy(), np.empty((1, x.shape[1]))
    for s in range(len(starts)):
        for t in range(starts[s] + 1, starts[s] + steps + 1):
            _move(model, data, t, x, s, s, work)
        _vary(model, H, data.grown[starts[s] + steps])
        for o in range(len(H)):
            out[s, o] = _row_dot(model, H, o, x, s)
