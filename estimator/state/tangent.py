"""How everything that a model's terms yield moves with one parameter, by complex step.

The terms are evaluated once at p + i h; the imaginary part over h is the derivative, exact to rounding (Squire and
Trapp 1998). No effect writes a derivative.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from estimator.inputs.inputs import Inputs
from estimator.model import Model
from estimator.network import assemble
from estimator.network.assemble import Network
from estimator.network.forcing import Drive, Forcing
from estimator.record import Array
from estimator.rig import Rig
from estimator.state.open_loop import lag_filter
from estimator.state.run import Run
from estimator.terms import OF_READINGS, OF_TICKS, Chain, Heat, Link, Shift, Store, Term

STEP = 1e-30


@dataclass(frozen=True)
class ReadingsTangent:
    """Derivatives of rows (m, n), growth (n,), spans, variance, lag variance, walk, keep and ramp (m,), x0 and P0."""

    rows: Array
    growth: Array
    spans: Array
    variance: Array
    lag_variance: Array
    walk: Array
    keep: Array
    ramp: Array
    x0: Array
    P0: Array

    @property
    def moves(self) -> bool:
        """Whether channels read temperatures otherwise, and not only what the run began with."""
        return any(np.any(part) for part in (self.rows, self.growth, self.keep, self.ramp))

    @classmethod
    def none(cls, channels: int, n: int, size: int) -> "ReadingsTangent":
        """Readings that do not move."""
        m = np.zeros(channels)
        return cls(np.zeros((channels, n)), np.zeros(n), m, m, m, m, m, m, np.zeros(size), np.zeros((size, size)))


@dataclass(frozen=True)
class TicksTangent:
    """Derivatives of heat (K, n), outside (K, boundaries) and offset (K, m) of some ticks."""

    heat: Array
    outside: Array
    offset: Array

    @classmethod
    def none(cls, ticks: int, n: int, boundaries: int, channels: int) -> "TicksTangent":
        """Ticks that do not move, but for their regimes."""
        return cls(np.zeros((ticks, n)), np.zeros((ticks, boundaries)), np.zeros((ticks, channels)))


class Moved:
    """A model, forced as another of the same structure, with one parameter "effect.param" moved."""

    def __init__(self, forcing: Forcing, model: Model, path: str) -> None:
        self._forcing, self._model, self.path = forcing, model.with_values({path: model[path] + 1j * STEP}), path
        self._effects = model.moved_by(path.partition(".")[0])
        if path.partition(".")[0] in model.correcting:
            self._effects = [name for name in self._effects if name in model.use or self._hears(name)]

    def _hears(self, name: str) -> bool:
        """Whether an effect says anything else where the inputs are set right."""
        rig, model = self._forcing.rig, self._model
        terms = model.terms_of(name, model.inputs(self._forcing.nothing, rig), rig)
        return any(map(assemble.is_complex, terms))

    def network(self, which: Sequence[int] | None = None) -> Network:
        """Derivatives of the network of some regimes met so far, or of all."""
        rig, place = self._forcing.rig, self._forcing.place
        if not (self.in_regimes or self._scatters or self._is_own):
            return Network.none(place, self._forcing.regimes if which is None else len(which))
        u = self._model.inputs(self._forcing.regime_inputs(which), rig)
        moves = assemble.network_of(moving(self._model, self._effects, u, rig), place, len(u))
        return Network(**{key: slope(value) for key, value in vars(moves).items()})

    def ticks(self, drive: Drive) -> TicksTangent:
        """Derivatives of what the model makes of some ticks."""
        rig, place = self._forcing.rig, self._forcing.place
        if not self.in_ticks:
            return TicksTangent.none(len(drive.inputs), place.size, place.boundaries, len(rig.names))
        return drive.by_parts(self._ticks)

    def _ticks(self, drive: Drive) -> TicksTangent:
        rig, place = self._forcing.rig, self._forcing.place
        u = self._model.inputs(drive.inputs, rig)
        terms = moving(self._model, self.effects_in_ticks, u, rig)
        outside = np.zeros((len(u), place.boundaries))
        if Shift in self._kinds:
            outside = slope(assemble.outside(list(self._model.terms(u, rig)), u, place))
        heat, offset = assemble.heat(terms, place, len(u), drive.spread), assemble.offsets(terms, rig, len(u))
        return TicksTangent(slope(heat), outside, slope(offset))

    def readings(self, run: Run, offset: Array, moved_offset: Array) -> ReadingsTangent | None:
        """Derivatives of how the channels read, None where nothing of it moves; `offset` (m,): of the first sample."""
        rig, place = self._forcing.rig, self._forcing.place
        if not self._kinds & {*OF_READINGS}:
            return None
        if not self._in_readings:
            x0, _ = run.estimate(self._forcing.readings, self._forcing.terms, place, offset + 1j * STEP * moved_offset)
            return replace(ReadingsTangent.none(len(rig.names), place.size, len(x0)), x0=slope(x0))
        u = self._forcing.nothing
        terms = [term for name in self._forcing.reading for term in self._model.terms_of(name, u, rig)]
        moved = assemble.readings(terms, rig, place)
        keep, ramp = lag_filter(moved.tau, rig.tick_s)
        known = np.isfinite(moved.sd)
        variance = np.where(known, np.where(known, moved.sd, 1.0) ** 2, 1.0)
        x0, P0 = run.estimate(moved, self._forcing.terms, place, offset + 1j * STEP * moved_offset)
        parts = (moved.rows, moved.growth, moved.spans, variance, moved.lag_noise**2, moved.zero_walk**2, keep, ramp)
        return ReadingsTangent(*(slope(value) for value in (*parts, x0, P0)))

    @property
    def effects_in_ticks(self) -> list[str]:
        """Those of its effects that say something of a tick."""
        return [name for name, kinds in self._kinds_of.items() if kinds & {*OF_TICKS}]

    @property
    def in_ticks(self) -> bool:
        """Whether it may move what is said of a tick, and not of its regime alone."""
        return bool(self._kinds & {*OF_TICKS})

    @property
    def by_rows(self) -> bool:
        """Whether columns of values can be asked of its effects: a user's own need not work on them."""
        effect, _, key = self.path.partition(".")
        chooses = self._model.effects[effect].params[key].over == "channel" or effect in self._model.correcting
        chooses = chooses or self._model.effects[effect].apart
        return self.in_ticks and not chooses and Shift not in self._kinds and not self._is_own

    @property
    def in_regimes(self) -> bool:
        """Whether it may move what a regime stores and conducts."""
        return bool(self._kinds & {Store, Chain, Link})

    @property
    def _in_readings(self) -> bool:
        """Whether it moves how channels read the temperatures, and not only what they read beside them."""
        said = [term for some in self._still.values() for term in some if isinstance(term, OF_READINGS)]
        return any(assemble.is_complex(term, but="offset") for term in said)

    @property
    def _is_own(self) -> bool:
        """Whether a user's own effect moves: what it says at rest need not be all."""
        return bool({*self._effects} & {*self._model.use})

    @property
    def _scatters(self) -> bool:
        """Whether it moves how the heat of its effects scatters, and where."""
        heats = [term for some in self._still.values() for term in some if isinstance(term, Heat)]
        noisy = [term for term in heats if np.ndim(term.noise) or term.noise != 0.0]
        return any(assemble.is_complex_value(value) for term in noisy for value in (term.noise, term.over))

    @cached_property
    def _kinds(self) -> set[type]:
        """Of which kinds the terms are that move."""
        return set().union(*self._kinds_of.values())

    @cached_property
    def _kinds_of(self) -> dict[str, set[type]]:
        """The same by effect, whatever the inputs."""
        return {name: {type(term) for term in terms} for name, terms in self._still.items()}

    @cached_property
    def _still(self) -> dict[str, list[Term]]:
        """What its effects say at rest, by effect."""
        rig, u = self._forcing.rig, self._forcing.nothing
        return {name: self._model.terms_of(name, u, rig) for name in self._effects}


class MovedApart:
    """A model whose parameters move in a row each: derivatives of one tick by all of them, asked once."""

    def __init__(self, forcing: Forcing, moved: Sequence[Moved]) -> None:
        model, self._forcing, self._rows = forcing.model, forcing, len(moved)
        columns = 1j * STEP * np.eye(len(moved))[:, :, None]
        self._model = model.with_values({one.path: model[one.path] + h for one, h in zip(moved, columns, strict=True)})
        self._effects = sorted({name for each in moved for name in each.effects_in_ticks})

    def tick(self, drive: Drive) -> tuple[Array, Array]:
        """Derivatives of heat (q, n) and offset (q, m), a row for each."""
        rig, place = self._forcing.rig, self._forcing.place
        u = self._model.inputs(drive.inputs, rig)
        terms = moving(self._model, self._effects, u, rig)
        heat = assemble.heat(terms, place, self._rows, drive.spread)
        return slope(heat), slope(assemble.offsets(terms, rig, self._rows))


def moving(model: Model, effects: Iterable[str], u: Inputs, rig: Rig) -> list[Term]:
    """Terms of some effects of a model with a complex step that move: of sums over terms the others are no part."""
    said = (term for name in effects for term in model.terms_of(name, u, rig))
    return [term for term in said if assemble.is_complex(term)]


def slope(value: Array) -> Array:
    """Derivative of a value after a complex step."""
    return np.asarray(np.imag(value) / STEP)
