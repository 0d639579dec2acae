"""The filter over a whole recording, with the judge that the online filter has: which readings to fuse is found as it
goes. Ticks are filtered a stretch at a time, as if nothing happened to any channel; what the judge has not to say
anything of stays. Beside it goes one that hears no length."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from estimator.batch import batch
from estimator.batch.ahead import Ahead
from estimator.batch.system import Chunk, System
from estimator.faults.fault import Fault, Judgement, Led, Seen
from estimator.faults.judge import Judge
from estimator.record import Array
from estimator.rig import Rig
from estimator.state.doubt import Doubt
from estimator.state.moves import Moves
from estimator.state.state import State

SHORTEST, LONGEST = 4, 256  # ticks of a stretch


@dataclass(frozen=True)
class Readings:
    """What a judge needs beside the filter: time (T,); of channels, (T, m): reading, by the model alone, muted.

    ahead  how the latter move with what the model's parameters may be off by
    astray, driven  (T,) whether heat is in the wrong place; whether the screw has turned
    """

    time_s: Array
    reading: Array
    alone: Array
    muted: Array
    ahead: Ahead
    astray: Array
    driven: Array

    def seen(self, system: System, chunk: Chunk, moves: Moves, led: Led) -> Seen:
        """A chunk's ticks as the judge is shown them."""
        at = chunk.ticks
        value = system.y[at] - chunk.predicted
        return Seen(
            self.time_s[at],
            self.reading[at],
            value,
            chunk.sd,
            self.alone[at],
            self.muted[at],
            moves.readings,
            led,
            self.astray[at],
            self.driven[at],
        )


@dataclass(frozen=True)
class Judged:
    """Some ticks, filtered and judged; with `anew` the run begins again with the last of them.

    after  x, P after the last, as judged;   unled  x (K, size) of the filter that hears no length, and its doubt
    led    how far lengths have led from that one
    """

    chunk: Chunk
    judgement: Judgement
    moves: Moves
    after: tuple[Array, Array]
    unled: Array
    led: Led
    doubt: Doubt


class Unled:
    """The filter that hears no length, some ticks at a time; where there is none to hear, the other one is asked.

    What its elongation is in doubt by is asked where lengths have led far, and that is most often never: as long as
    nobody wants it for itself, `closely`, it is left behind, and goes once over all that it has left out.
    """

    def __init__(
        self, system: System, state: State, doubt: Doubt, rig: Rig, closely: bool, again: Callable[[], Ahead]
    ) -> None:
        """again  the moves of the run, from its begin on"""
        heat, self._tick_s, self._closely, self._again = rig.is_thermometer, rig.tick_s, closely, again
        self._left = list[tuple[slice, Array, tuple[Array, Array]]]()  # ticks, what is fused, x and P before
        self._system, self._state, self._heat, self.doubt = system, state, heat, doubt.beside()
        self.last = system.x0, system.P0
        self._any = bool(system.data.use[:, ~heat].any())
        self._led = Led.nowhere(1, len(doubt.known.whole))
        self._found: tuple[Chunk, Doubt, Led] | None = None

    def led(self, chunk: Chunk, moves: Moves) -> Led:
        """How far lengths have led the other filter, at the tick before each."""
        if not self._any:
            return Led.nowhere(len(chunk.x), self._led.doubt.shape[1])
        fused, doubt = chunk.fused & self._heat, self.doubt.beside()
        own = self._filtered(chunk.ticks, fused, self.last)
        um, var = self._state.led(self._system.grown[chunk.ticks], chunk.x, (own.x, own.P))
        growth = np.zeros((len(um), self._led.doubt.shape[1]))
        led = Led(um, var, growth, *self._led.worsened(own.nis / own.fused.sum(axis=1).clip(1), self._tick_s))
        if led.far.any() and not self._closely:
            self._catch_up()
            return self.led(chunk, moves)
        if self._closely:
            led = replace(led, doubt=doubt.slopes(moves, own.gain)[1])
        self._found = own, doubt, led
        return led.later(self._led)

    def _filtered(self, ticks: slice, fused: Array, start: tuple[Array, Array]) -> Chunk:
        return batch.filtered(self._system, ticks, fused, start, spread=False, gains=self._closely)

    def _catch_up(self) -> None:
        """Go over all that was left out, and leave out nothing from now on."""
        self._closely, ahead = True, self._again()
        for ticks, fused, start in self._left:
            self.doubt.slopes(ahead.rows(ticks), self._filtered(ticks, fused, start).gain)
        self._left.clear()

    def take(self, chunk: Chunk, judgement: Judgement, moves: Moves, after: tuple[Array, Array]) -> tuple[Array, Led]:
        """The ticks as they have been judged; its own x, (K, size), and how far lengths have led from it."""
        if self._found is None:
            self.last = after
            return chunk.x, Led.nowhere(len(chunk.x), self._led.doubt.shape[1])
        if not np.array_equal(self._found[0].fused, chunk.fused & self._heat):
            self.led(chunk, moves)
        own, self.doubt, led = self._found
        if not self._closely:
            x0, P0 = (each.copy() for each in self.last)  # a view would keep all that was filtered
            self._left.append((chunk.ticks, own.fused, (x0, P0)))
        self.last = self._state.judged(own.x[-1], own.P[-1], judgement)
        own.x[-1] = self.last[0]
        at = slice(chunk.ticks.stop - 1, chunk.ticks.stop)
        x = self.last[0] if judgement.apart else after[0]
        um, var = self._state.led(self._system.grown[at], x[None], (own.x[-1:], self.last[1][None]))
        self._led = replace(led[-1:], um=um, var=var)
        return own.x, Led.joined(led[:-1], self._led)


def judged(
    system: System, readings: Readings, judge: Judge, state: State, unled: Unled, gains: bool
) -> Iterator[Judged]:
    """All ticks of a system, some at a time, with their gains if asked, up to one with which the run begins anew."""
    start, at, length = (system.x0, system.P0), 0, LONGEST
    while at < len(system.y):
        ticks = slice(at, min(at + length, len(system.y)))
        chunk = batch.filtered(system, ticks, system.data.use[ticks] & judge.well, start, gains=gains)
        moves = readings.ahead.rows(ticks)
        judgement = judge.judge(readings.seen(system, chunk, moves, unled.led(chunk, moves)))
        K = len(judgement.fault)
        chunk, moves = _as_judged(system, chunk.rows(slice(0, K)), judgement, start), moves.rows(slice(0, K))
        start = state.judged(chunk.x[-1], chunk.P[-1], judgement)
        x, led = unled.take(chunk, judgement, moves, start)
        start = unled.last if judgement.apart else start
        yield Judged(chunk, judgement, moves, start, x, led, unled.doubt)
        if judgement.anew:
            return
        length = min(2 * length, LONGEST) if ticks.stop - at == K else max(SHORTEST, K)
        at += K


def _as_judged(system: System, chunk: Chunk, judgement: Judgement, start: tuple[Array, Array]) -> Chunk:
    """The chunk with its last tick filtered again, if that was to be fused in another way."""
    last = chunk.ticks.stop - 1
    use = system.data.use[last] & (judgement.fault[-1] == Fault.NONE)
    if np.array_equal(use, chunk.fused[-1]):
        return chunk
    before = (chunk.x[-2], chunk.P[-2]) if len(chunk.x) > 1 else start
    return chunk.with_last(batch.filtered(system, slice(last, last + 1), use[None], before, gains=len(chunk.gain) > 0))
