"""A whole recording at once: likelihood, smoother, and derivatives.

    predict   x <- F x + b         P <- F P F' + Q
    compare   e = y - H x          S = H P H' + R
    update    x <- x + K e         K = P H' S^-1

The first d states move; the others are constants, which may walk: F is the identity there. Every tick predicts, then
updates. Where all ticks do not fit into memory at once they are filtered twice: once to the end, keeping the state at
the borders of chunks, and once more chunk by chunk on the way back.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from estimator.batch import kernels
from estimator.batch.kernels import Compared, Data, Slopes, Smooth, States
from estimator.batch.system import Chunk, Score, Smoothed, System
from estimator.record import Array

BUDGET = 20_000_000  # bytes for what is kept of each tick until the way back
NEAR = 2_000_000  # bytes that stay close to the processor, for what is used up at once


def is_cold(*functions: Callable[..., Any]) -> bool:
    """Whether any of these functions of this module, or of all, is still to be compiled: some seconds each, once."""
    forward = kernels.forward
    needs: dict[Callable[..., Any], tuple[Any, ...]] = {
        loglike: (forward,),
        passes: (kernels.compare,),
        smoothed: (forward, kernels.smooth),
        score: (forward, kernels.score),
        compared: (kernels.compare,),
        ahead: (kernels._coast,),
    }
    return not all(_is_compiled(kernel) for function in functions or needs for kernel in needs[function])


def passes(system: System, spread: bool = True) -> Iterator[Chunk]:
    """Filter, chunk by chunk. Every reading is compared, also those that are not to be fused; `spread`: with its sd."""
    start = system.x0, system.P0
    for ticks in chunks_of(system):
        chunk = filtered(system, ticks, system.data.use[ticks], start, spread)
        start = chunk.last if len(chunk.x) else start
        yield chunk


def compared(system: System, spread: Array | bool = True) -> Chunk:
    """All ticks, filtered, without their P but the last: to keep these takes longer than to find them.

    spread  (T, m), or one for all: where an sd is wanted
    """
    states = States(np.empty((len(system.y) + 1, len(system.x0))), system.start.P)
    states.x[0] = system.x0
    return _compared(system, slice(0, len(system.y)), system.data.use, states, spread, gains=False)


def chunks_of(system: System) -> list[slice]:
    """All ticks, in parts whose states stay close to the processor."""
    return _chunks(system, len(system.x0) ** 2, NEAR)


def filtered(
    system: System, ticks: slice, use: Array, start: tuple[Array, Array], spread: bool = True, gains: bool = True
) -> Chunk:
    """Filter some ticks from x (n,), P (n, n) on, fusing the readings to `use` (K, m); `spread` as in `passes`."""
    return _compared(system, ticks, use, _states(len(use), *start), spread, gains)


def _compared(system: System, ticks: slice, use: Array, states: States, spread: Array | bool, gains: bool) -> Chunk:
    (K, m), n = use.shape, len(system.x0)
    gain = np.empty((K if gains else 0, n, m))
    out = Compared(np.empty((K, m)), np.full((K, m), np.nan), gain, np.empty(K), np.empty(K))
    wanted = np.require(np.broadcast_to(spread, use.shape), bool, ["C", "W"])
    kernels.compare(system.model, _part(system.data, ticks)._replace(use=use), states, wanted, out)
    P = states.P[1:] if len(states.P) > 1 else states.P
    return Chunk(ticks, states.x[1:], P, out.predicted, out.sd, use, gain, out.nis, out.loglike)


def loglike(system: System) -> float:
    """Log-likelihood of the readings."""
    return float(kernels.forward(system.model, system.data, system.start))


def smoothed(system: System, covariances: bool = False, channels: Sequence[int] = ()) -> Smoothed:
    """Estimate of each tick from all readings (Durbin and Koopman 2012, 4.4), x + P r with covariance P - P N P.

    channels  (k,) of which the smoothed reading is wanted
    """
    (T, n), k = system.b.shape, len(channels)
    cov = np.empty((T if covariances else 0, n, n))
    result = Smoothed(np.empty((T, n)), np.empty((T, n)), cov, np.empty((T, k)), np.empty((T, k)))
    _smooth(system, channels, lambda ticks: Smooth(*(a[ticks] for a in vars(result).values())))
    return result


def smoothed_reading(system: System, channel: int) -> tuple[Array, Array]:
    """The smoothed reading of one channel alone, (T,), and its variance: the states of a day would fill 60 MB."""
    T, n = system.b.shape
    reading, none = np.empty((2, T, 1)), np.empty((0, n, n))

    def room(ticks: slice) -> Smooth:
        return Smooth(np.empty((ticks.stop - ticks.start, n)), none[:, 0], none, reading[0, ticks], reading[1, ticks])

    _smooth(system, [channel], room)
    return reading[0, :, 0], reading[1, :, 0]


def _smooth(system: System, channels: Sequence[int], room: Callable[[slice], Smooth]) -> None:
    """Fill the room for each chunk, from the last to the first."""
    n, which = len(system.x0), np.array(channels, dtype=np.int64)
    r, N = np.zeros(n), np.zeros((n, n))
    for ticks, states, _ in _backwards(system):
        kernels.smooth(system.model, _part(system.data, ticks), which, states, r, N, room(ticks))


def score(system: System) -> Score:
    """Log-likelihood and its exact derivatives by what scatters, and by readings and growth."""
    (T, m), n, total = system.y.shape, len(system.x0), 0.0
    Q, y, R, grown = np.zeros(system.model.Q.shape), np.zeros((T, m)), np.zeros((T, m)), np.zeros(T)
    r, N = np.zeros(n), np.zeros((n, n))
    for ticks, states, value in _backwards(system):
        out = Slopes(y[ticks], R[ticks], grown[ticks], Q)
        kernels.score(system.model, _part(system.data, ticks), states, r, N, out)
        total += value
    return Score(total, 0.5 * Q, y, R, grown, r, 0.5 * (np.outer(r, r) - N))


def ahead(system: System, x: Array, steps: int, every: int) -> tuple[Array, Array]:
    """Starts 0, every, 2 every ... (S,) and what each channel reads `steps` later without a reading since, (S, m).

    x  (T, n) filtered
    """
    starts = np.arange(0, max(len(system.y) - steps, 0), every)
    x = x[starts]
    for i, start in enumerate(starts):
        x[i] = _run(system, slice(start + 1, start + steps + 1), x[i])[-1]
    readings = x @ system.H.T
    if system.column >= 0:
        readings += (x[:, system.column] * system.grown[starts + steps])[:, None] * system.spans
    return starts, readings


def _run(system: System, ticks: slice, x: Array) -> Array:
    """The mean after each of some ticks, (K, n), from x (n,) on without readings."""
    d = system.F.shape[1]
    moving = kernels.coast(system.F, system.regime[ticks], system.b[ticks, :d], x[:d])
    return np.hstack([moving, np.tile(x[d:], (len(moving), 1))])


def _part(data: Data, ticks: slice) -> Data:
    return Data(*(a[ticks] for a in data))


def _chunks(system: System, numbers: int, budget: int) -> list[slice]:
    """All ticks, in parts of which each takes no more bytes for so many numbers a tick."""
    T, length = len(system.y), max(1, budget // (8 * max(numbers, 1)))
    return [slice(first, min(first + length, T)) for first in range(0, max(T, 1), length)]


def _states(ticks: int, x: Array, P: Array) -> States:
    """Room for the states of that many ticks, after the given one."""
    states = States(np.empty((ticks + 1, *x.shape)), np.empty((ticks + 1, *P.shape)))
    states.x[0], states.P[0] = x, P
    return states


def _backwards(system: System) -> Iterator[tuple[slice, States, float]]:
    """Chunks from the last to the first: ticks, all states, log-likelihood."""
    n = len(system.x0)
    chunks, state = _chunks(system, n * n + n, BUDGET), system.start
    borders = [States(*(a.copy() for a in state))]
    for ticks in chunks[:-1]:
        kernels.forward(system.model, _part(system.data, ticks), state)
        borders.append(States(*(a.copy() for a in state)))
    room = States(*(np.empty((chunks[0].stop + 1, *a.shape[1:])) for a in state))
    for ticks, border in zip(reversed(chunks), reversed(borders)):
        states = States(*(a[: ticks.stop - ticks.start + 1] for a in room))
        states.x[0], states.P[0] = border.x[0], border.P[0]
        yield ticks, states, float(kernels.forward(system.model, _part(system.data, ticks), states))


def _is_compiled(kernel: Any) -> bool:
    """Whether numba has the code in memory, or in its cache, of this very source and for this processor."""
    kernel = kernel.dispatcher
    if kernel.signatures or kernel.stats.cache_path is None:
        return bool(kernel.signatures)
    processor = kernel.targetctx.codegen().magic_tuple()
    return any(key[1] == processor for key in kernel._cache._cache_file._load_index())  # as numba itself looks it up
