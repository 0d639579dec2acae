"""The filter over a whole recording, with the judge that the online filter has: which readings to fuse is found as it
goes. Ticks are filtered a stretch at a time, as if nothing happened to any channel; what the judge has not to say
anything of stays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from estimator.batch import batch
from estimator.batch.ahead import Ahead
from estimator.batch.system import Chunk, System
from estimator.faults.fault import Fault, Judgement, Seen
from estimator.faults.judge import Judge
from estimator.record import Array
from estimator.state.moves import Moves
from estimator.state.state import State

SHORTEST, LONGEST = 4, 256  # ticks of a stretch


@dataclass(frozen=True)
class Readings:
    """What a judge needs beside the filter: time (T,); of channels, (T, m): reading, by the model alone, muted.

    ahead  how the latter move with what the model's parameters may be off by
    """

    time_s: Array
    reading: Array
    alone: Array
    muted: Array
    ahead: Ahead

    def seen(self, system: System, chunk: Chunk, moves: Moves, before: Array) -> Seen:
        """A chunk's ticks as the judge is shown them, after the state before."""
        at = chunk.ticks
        value = system.y[at] - chunk.predicted
        expansion = np.append(before[system.column], chunk.x[:-1, system.column])
        return Seen(
            self.time_s[at],
            self.reading[at],
            value,
            chunk.sd,
            self.alone[at],
            self.muted[at],
            moves.readings,
            expansion,
        )


@dataclass(frozen=True)
class Judged:
    """Some ticks, filtered and judged; with `anew` the run begins again with the last of them."""

    chunk: Chunk
    judgement: Judgement
    moves: Moves


def judged(system: System, readings: Readings, judge: Judge, state: State) -> Iterator[Judged]:
    """All ticks of a system, some at a time, up to one with which the run begins anew."""
    start, at, length = (system.x0, system.P0), 0, LONGEST
    while at < len(system.y):
        ticks = slice(at, min(at + length, len(system.y)))
        chunk = batch.filtered(system, ticks, system.data.use[ticks] & judge.well, start)
        moves = readings.ahead.rows(ticks)
        judgement = judge.judge(readings.seen(system, chunk, moves, start[0]))
        K = len(judgement.fault)
        chunk = _as_judged(system, chunk.rows(slice(0, K)), judgement, start)
        yield Judged(chunk, judgement, moves.rows(slice(0, K)))
        if judgement.anew:
            return
        start = state.judged(*chunk.last, judgement)
        length = min(2 * length, LONGEST) if ticks.stop - at == K else max(SHORTEST, K)
        at += K


def _as_judged(system: System, chunk: Chunk, judgement: Judgement, start: tuple[Array, Array]) -> Chunk:
    """The chunk with its last tick filtered again, if that was to be fused in another way."""
    last = chunk.ticks.stop - 1
    use = system.data.use[last] & (judgement.fault[-1] == Fault.NONE)
    if np.array_equal(use, chunk.fused[-1]):
        return chunk
    before = (chunk.x[-2], chunk.P[-2]) if len(chunk.x) > 1 else start
    return chunk.with_last(batch.filtered(system, slice(last, last + 1), use[None], before))
