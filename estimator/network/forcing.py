"""What the inputs do to the model, tick by tick: regime, heat and reading offsets.

Works on any number of ticks at once and remembers what it must between calls, so that a recording in one piece and a
bus tick by tick give the same numbers.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from estimator.cover import AT_ONCE, LONG
from estimator.faults.travel import Travel, motions
from estimator.inputs.balls import Balls, ByBalls
from estimator.inputs.inputs import InputReader, Inputs, no_inputs, nothing
from estimator.inputs.start import Start
from estimator.inputs.untold import Untold
from estimator.model import Model
from estimator.network import assemble
from estimator.network.check import checked_terms
from estimator.network.discretise import Modes, Transition
from estimator.network.layout import Layout, layout
from estimator.network.regime import Regimes
from estimator.network.sound import Sound
from estimator.network.unknown import unknown_heat
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.terms import OF_READINGS

Made = TypeVar("Made")


@dataclass(frozen=True)
class Drive:
    """Inputs of K ticks with the regime (K,) each belongs to: all that a model needs to know of a run.

    astray  (K,) whether they put heat in the wrong place, or did within the last hours
    driven  (K,) whether the screw has turned since the run began
    """

    inputs: Inputs
    regime: Array
    astray: Array
    driven: Array
    _covered: dict[tuple[tuple[int, ...], bool], tuple[Balls | None, Array]] = field(default_factory=dict)

    def rows(self, at: slice) -> "Drive":
        """Some of the ticks."""
        return Drive(self.inputs.rows(at), self.regime[at], self.astray[at], self.driven[at])

    def by_parts(self, make: "Callable[[Drive], Made]") -> Made:
        """A record of arrays (K, ...) that is made of all ticks; of a long run some at a time, or they fill memory."""
        if len(self.regime) <= LONG:
            return make(self)
        parts = [make(self.rows(slice(k, k + AT_ONCE))) for k in range(0, len(self.regime), AT_ONCE)]
        return type(parts[0])(*map(np.concatenate, zip(*(vars(part).values() for part in parts), strict=True)))

    def spread(self, q: Any, over: Any, rows: Array) -> Array:
        """As `assemble.spread`, (K, n); the coverage is projected once for all models of a rig, and that by the balls
        for all that have them where the last model has."""
        balls = over.balls if isinstance(over, ByBalls) and not over.is_complex else None
        cover = over.cover if balls else over
        if cover is not self.inputs.coverage or np.shape(q)[-1] != 1:
            return assemble.spread(q, over, rows)
        kind = (rows.shape, balls is not None)
        known, covered = self._covered.get(kind, (None, None))
        if covered is None or known != balls:
            covered = assemble.spread(1.0, over, rows)
            self._covered[kind] = balls, covered
        return np.asarray(q * covered)


@dataclass(frozen=True)
class Solved:
    """What follows from one regime: its modes, one tick, and W/K from each boundary into the states."""

    modes: Modes
    transition: Transition
    inflow: Array


@dataclass(frozen=True)
class Ticks:
    """K ticks made ready for the filter.

    regime   (K,)    which transition
    heat     (K, n)  W into the states: sources and boundaries
    offset   (K, m)  what the channels read beside the temperatures
    outside  (K, boundaries) what links end at outside
    """

    regime: Array
    heat: Array
    offset: Array
    outside: Array


class Forcing:
    """Turns inputs into regimes, heat and offsets for one model on one rig, from one start.

    reduced  False keeps every cell as a state: exact, slow, to check the reduced mesh with
    keep     how many regimes are kept solved; the one used longest ago is solved again when it comes back. A machine
             that never does the same twice meets more of them in a week than the memory holds
    like     the same inputs and regimes under another model; what its effects are was checked where they are the same
    """

    def __init__(
        self,
        model: Model,
        rig: Rig,
        start: Start,
        reduced: bool = True,
        keep: int | None = None,
        like: "Forcing | None" = None,
    ) -> None:
        self.model, self.rig, self.start = model, rig, start
        self._reader: InputReader = like._reader if like else InputReader(rig, start)
        self._regimes: Regimes = like._regimes if like else Regimes(rig.tick_s, forgets=keep is not None)
        self._travel: Travel = like._travel if like else Travel(rig)
        self._untold: Untold = like._untold if like else Untold(rig)
        self._keep, self._driven = keep, False
        self._solved: dict[int, Solved] = {}
        self._latest: Forcing | None = None
        self._asked: dict[tuple[int, ...], Inputs] = like._asked if like else {}  # of those regimes that were last
        self._sound = Sound(model, rig)
        self.nothing: Inputs = like.nothing if like else nothing(rig)
        checked = like is not None and not model.use and _kinds(like.model) == _kinds(model)
        if checked:
            self.terms = self._sound.terms(self.nothing, forced=False)
        else:
            self.terms = checked_terms(model, self.nothing, rig, self._sound)
        same = checked and like is not None and not like.place.shifts
        self.place: Layout = like.place if like and same else layout(self.terms, rig, reduced)
        self.readings = assemble.readings(self.terms, rig, self.place)

    def with_model(self, model: Model) -> "Forcing":
        """The same inputs and regimes under another model. What was checked of its kind stands while it is the last."""
        known = self._latest if self._latest and _kinds(self._latest.model) == _kinds(model) else self
        self._latest = Forcing(model, self.rig, self.start, keep=self._keep, like=known)
        return self._latest

    @property
    def input_fault(self) -> Array:
        """Why each input was held at the last tick read, (p,), a Fault each."""
        return self._reader.gate.fault

    @cached_property
    def reading(self) -> list[str]:
        """Effects that say how channels read."""
        said = {name: self.model.terms_of(name, self.nothing, self.rig) for name in self.model.effects}
        return [name for name, terms in said.items() if any(isinstance(term, OF_READINGS) for term in terms)]

    @property
    def memory_s(self) -> float:
        """How long a rig that stands, and is as warm everywhere, takes to lose its heat at the rate at which it begins.

        1'M 1 / 1'G 1, capacities over conductances to what is outside, s; inf where it loses none
        """
        network = assemble.network_of(self.terms, self.place, 1)
        stored, lost = float(network.mass.sum()), float(network.conductance.sum())
        return stored / lost if lost > 0.0 else float("inf")

    @property
    def regimes(self) -> int:
        """How many have been met so far."""
        return len(self._regimes.met)

    @property
    def modes(self) -> list[Modes]:
        """Modes of all regimes met so far."""
        return [self._solved[regime].modes for regime in range(self.regimes)]

    def modes_of(self, regime: int) -> Modes:
        """Modes of a regime."""
        return self._solved[regime].modes

    def transition(self, regime: int) -> Transition:
        """Transition of a regime."""
        return self._solved[regime].transition

    def read(self, chunk: Recording) -> Drive:
        """Inputs and regimes of a chunk, whatever the model; call in order of time."""
        u, stay, regime, astray = self._reader.read(chunk), self._reader.stay(chunk), [], []
        unseen = self._untold.unseen(chunk)
        speeds = np.hstack([np.broadcast_to(each, u.omega.shape) for each in (u.omega, u.unevenness, u.idle, u.rest_K)])
        before: tuple[list[float], Array] = [], np.empty(0)
        for sample, row, under, lost in zip(motions(chunk), speeds.tolist(), stay, unseen.tolist(), strict=True):
            self._travel.step(sample)
            omega, uneven, idle, rest_K = row
            unknown = lost or bool(self._travel.why)
            again = row == before[0] and np.array_equal(under, before[1])
            regime.append(self._regimes.index(omega, under, unknown, uneven, idle, rest_K, again))
            astray.append(self._travel.astray)
            before = row, under
        driven = np.logical_or.accumulate(u.omega[:, 0] > 0.0) | self._driven
        self._driven = bool(driven[-1])
        return Drive(u, np.array(regime), np.array(astray), driven)

    def ticks(self, drive: Drive) -> Ticks:
        """What the model makes of these inputs; an EffectError where an effect makes no number of them."""
        self._solve(sorted(set(drive.regime.tolist())))
        return drive.by_parts(self._ticks)

    def _ticks(self, drive: Drive) -> Ticks:
        u, regime = self.model.inputs(drive.inputs, self.rig), drive.regime
        terms = self._sound.terms(u)
        heat = assemble.heat(terms, self.place, len(u), drive.spread)
        outside = assemble.outside(terms, u, self.place)
        for r in sorted(set(regime.tolist())):
            heat[regime == r] += outside[regime == r] @ self._solved[r].inflow.T
        offset = assemble.offsets(terms, self.rig, len(u))
        if not (np.isfinite(heat).all() and np.isfinite(offset).all()):
            raise self._sound.blame(u)
        return Ticks(regime, heat, offset, outside)

    def response(self, ticks: Ticks) -> tuple[Array, Array]:
        """F (R, n, n) of the regimes, and J w, (K, n): what each tick's heat does to the states."""
        moves = [self._solved[regime].transition for regime in range(ticks.regime.max() + 1)]
        b = np.empty_like(ticks.heat)
        for r, move in enumerate(moves):
            b[ticks.regime == r] = ticks.heat[ticks.regime == r] @ move.J.T
        return np.array([move.F for move in moves]), b

    def inflow(self, regime: int) -> Array:
        """W/K from each boundary into the states, (n, boundaries)."""
        return self._solved[regime].inflow

    def regime_inputs(self, which: Sequence[int] | None = None) -> Inputs:
        """Speed and coverage of some regimes met so far, or of all; every other input is zero."""
        which = tuple(range(self.regimes) if which is None else which)
        if which not in self._asked:
            self._asked.clear()
            met = [self._regimes.met[r] for r in which]
            rows = [[each.omega, each.unevenness, each.idle, each.rest_K] for each in met]
            omega, *others = np.array(rows).T[:, :, None]
            self._asked[which] = no_inputs(self.rig, omega, np.array([each.coverage for each in met]), *others)
        return self._asked[which]

    def _solve(self, needed: Sequence[int]) -> None:
        """Assemble and discretise all regimes met and not solved; those that are needed, where not all are kept."""
        wanted = range(self.regimes) if self._keep is None else needed
        self._forget(needed)
        missing = [regime for regime in wanted if regime not in self._solved]
        if not missing:
            return
        u = self.model.inputs(self.regime_inputs(missing), self.rig)
        terms = self._sound.terms(u, forced=False)
        network = assemble.network_of(terms, self.place, len(missing))
        for i, regime in enumerate(missing):
            modes = Modes(network, i, self.rig.tick_s)
            move = modes.transition()
            if self._regimes.met[regime].unknown:
                move = replace(move, Q=move.Q + unknown_heat(self.place, self.rig.tick_s))
            self._solved[regime] = Solved(modes, move, network.inflow[i])

    def _forget(self, needed: Sequence[int]) -> None:
        """Let go of the regimes used longest ago."""
        if self._keep is None:
            return
        for regime in needed:
            if regime in self._solved:
                self._solved[regime] = self._solved.pop(regime)  # to the end of the queue
        while len(self._solved) > self._keep:
            del self._solved[next(iter(self._solved))]


def _kinds(model: Model) -> list[type]:
    return [type(effect) for effect in model.effects.values()]
