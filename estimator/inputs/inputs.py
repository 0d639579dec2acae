"""The inputs u of the model: measured and taken as exact, as columns over time."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from estimator.cover import LONG, Cover
from estimator.errors import SetupError, nearest
from estimator.inputs.gate import InputGate
from estimator.inputs.motion import Motion, MotionReader
from estimator.inputs.start import Start
from estimator.record import Array, Recording, held
from estimator.rig import Rig
from estimator.screw import Screw
from estimator.terms import START

TICKS = 2


@dataclass(frozen=True)
class Inputs:
    """Inputs of `ticks` ticks. Every scalar is a column (ticks, 1), so that it broadcasts against a place (cells,).

    omega     rad/s, mean of |speed| over the tick
    coverage  (ticks, cells) share of the tick in which the nut covers each cell; of a long run a Cover
    seats     (cells,) share of each cell inside a bearing
    values    other inputs by name, in the rig file's unit; "start": the temperature at which the run started
    rises     their changes since they were first seen; 0 before that
    motion    time since the start, and what the motion so far leaves behind
    unevenness  mean of speed^2 over the square of the mean speed, within each tick
    idle      share of each tick in which the screw stands though it turns before or after
    rest_K    about how warm the screw is where it stands, in steps within which it is one regime; 0 while it turns
    fault     (ticks, p) in the order of Rig.inputs: why an input is held, a Fault each
    """

    omega: Array
    coverage: Array | Cover
    values: Mapping[str, Array]
    rises: Mapping[str, Array]
    motion: Motion
    unevenness: Array | float = 1.0
    seats: Array | float = 0.0
    fault: Array = field(default_factory=lambda: np.zeros((0, 0), dtype=np.int8))
    idle: Array | float = 0.0
    rest_K: Array | float = 0.0

    def __post_init__(self) -> None:
        """No effect may write into what others read."""
        for key in ("omega", "coverage"):
            object.__setattr__(self, key, _read_only(getattr(self, key)))
        for key in ("values", "rises"):
            columns = {name: _read_only(column) for name, column in getattr(self, key).items()}
            object.__setattr__(self, key, columns)

    def __len__(self) -> int:
        return len(self.omega)

    def __getitem__(self, name: str) -> Array:
        if name not in self.values:
            raise SetupError(
                f"needs the input '{name}', which rig.toml has not in [inputs]; {nearest(name, self.values)}; add it "
                "or leave the effect out"
            )
        return self.values[name]

    def __contains__(self, name: str) -> bool:
        return name in self.values

    @cached_property
    def bare(self) -> Array:
        """(ticks, cells) share of each cell's surface that the air sees: under no nut, in no bearing's seat."""
        return np.asarray(_read_only((1.0 - self.coverage) * (1.0 - self.seats)))

    def speed_law(self, screw: Screw, n: Any) -> Array:
        """Mean of |omega / omega_ref|^n over each tick, (ticks, 1).

        w^n unevenness^(n - 1), w the mean relative speed: exact for n = 1 and n = 2, between them by Lyapunov's
        inequality the upper bound, 1.4 % too high at n = 1.4 for a stroke that is ramps for two thirds
        """
        return np.asarray(screw.relative_speed(self.omega) ** n * self.unevenness ** (n - 1))

    def air_law(self, screw: Screw, m: Any) -> Array:
        """The same for m < 1, of air, (ticks, 1): w^m (turning / unevenness)^((1 - m) / 2).

        The mean lies between w^m unevenness^(m - 1), as low for a stroke with a wait as it is, and w^m turning^(1 - m),
        turning the share of the time in which it does; their geometric mean is 0.5 % too high at m = 0.7
        """
        between = ((1.0 - self.idle) / self.unevenness) ** ((1 - m) / 2)
        return np.asarray(screw.relative_speed(self.omega) ** m * between)

    def rows(self, at: slice) -> "Inputs":
        """Some of the ticks."""
        values, rises = ({name: column[at] for name, column in each.items()} for each in (self.values, self.rises))
        by_tick = (self.unevenness, self.idle, self.rest_K)
        uneven, idle, rest_K = (each[at] if isinstance(each, np.ndarray) else each for each in by_tick)
        motion = self.motion.rows(at)
        cover = np.asarray(self.coverage[at])
        return Inputs(self.omega[at], cover, values, rises, motion, uneven, self.seats, self.fault[at], idle, rest_K)

    def rise(self, name: str) -> Array:
        """Change of an input since the start, (ticks, 1); 0 where the rig has no such input or it was never seen."""
        return self.rises.get(name, np.zeros_like(self.omega))


class InputReader:
    """Recordings into inputs: gaps and what the gate refuses held at the last known value, zeroed at a steady start.

    Before an input was ever seen a temperature is at the level of the thermometers, anything else at zero.
    """

    def __init__(self, rig: Rig, start: Start) -> None:
        self._rig, self._start = rig, start
        self._motion, self.gate = MotionReader(rig.tick_s, rig.screw, start.above_K), InputGate(rig, start)
        self._zero = np.array([start.zero_K.get(name, 0.0) for name in rig.inputs])
        self._unseen = np.array([start.level_C if each.unit == "degC" else 0.0 for each in rig.inputs.values()])
        self._last, self._first = np.full((2, len(rig.inputs)), np.nan)
        self._coverage = self._stay = np.zeros(rig.screw.cells if rig.screw else 0)

    def read(self, chunk: Recording) -> Inputs:
        """Inputs of the next ticks; call in order of time."""
        passed, fault = self.gate.passed(chunk)
        columns = held(passed - self._zero, self._last)[1:]
        known = np.isfinite(columns)
        first = columns[np.argmax(known, axis=0), np.arange(len(self._first))]
        self._first = np.where(np.isnan(self._first), first, self._first)
        self._last = columns[-1]
        values = self._by_name(np.where(known, columns, self._unseen))
        rises = self._by_name(np.where(known, columns - self._first, 0.0))
        values[START] = np.full((len(chunk), 1), self._start.level_C)
        coverage = _carried(chunk.coverage, chunk, self._coverage)
        self._coverage = coverage[-1].copy()
        coverage = coverage if len(chunk) > LONG else np.asarray(coverage)
        omega = np.nan_to_num(chunk.omega)
        uneven = np.where(np.isfinite(chunk.unevenness), chunk.unevenness, 1.0)
        idle = np.nan_to_num(chunk.idle)[:, None]
        motion = self._motion.read(omega)
        seats, rest_K = self._rig.seats, motion.rest_K
        return Inputs(omega[:, None], coverage, values, rises, motion, uneven[:, None], seats, fault, idle, rest_K)

    def stay(self, chunk: Recording) -> Array | Cover:
        """Coverage by time alone, which conductances go by, (ticks, cells); call in order of time."""
        stay = _carried(chunk.stay, chunk, self._stay)
        self._stay = stay[-1].copy()
        return stay

    def _by_name(self, columns: Array) -> dict[str, Array]:
        """Columns (ticks, p) in the order of Rig.inputs, each (ticks, 1)."""
        return {name: columns[:, i : i + 1] for i, name in enumerate(self._rig.inputs)}


def nothing(rig: Rig) -> Inputs:
    """One tick at rest with every input at zero: enough to ask a model for its structure."""
    return no_inputs(rig, np.zeros((1, 1)), np.zeros((1, rig.screw.cells if rig.screw else 0)))


def no_inputs(
    rig: Rig, omega: Array, coverage: Array, unevenness: Array | float = 1.0, idle: Array | float = 0.0,
    rest_K: Array | float = 0.0,
) -> Inputs:  # fmt: skip
    """Speeds with their unevenness, idle share and warmth at rest (ticks, 1), coverage (ticks, cells); nothing else."""
    none = {name: np.zeros_like(omega) for name in (*rig.inputs, START)}
    return Inputs(omega, coverage, none, none, Motion.none(len(omega)), unevenness, rig.seats, idle=idle, rest_K=rest_K)


def _carried(cover: Array | Cover, chunk: Recording, before: Array) -> Array | Cover:
    """Cover (ticks, cells) with ticks in which it is not known as the one before, the first as `before`."""
    known = cover.known if isinstance(cover, Cover) else ~np.isnan(cover).any(axis=1)
    gaps = np.isnan(chunk.omega) | ~known
    if not gaps.any():  # most of what a long recording is
        return cover
    at = np.maximum.accumulate(np.where(gaps, 0, np.arange(1, len(gaps) + 1)))
    if isinstance(cover, Cover):
        return Cover.joined([Cover.of(before[None].astype(cover.dtype)), cover])[at]
    return np.vstack([before, cover])[at]


def _read_only(array: Array | Cover) -> Array | Cover:
    """The same numbers, not to be written."""
    if isinstance(array, Cover):
        return array
    view = array.view()
    view.flags.writeable = False
    return view


class Held:
    """Fills short gaps of a series with the value before them; carries it from call to call."""

    def __init__(self) -> None:
        self._before = np.full(TICKS, np.nan)

    def held(self, values: Array) -> Array:
        """The next values, (n,), in order: NaN only where nothing was known for longer than TICKS."""
        series = np.concatenate([self._before, values])
        self._before = series[-TICKS:].copy()
        filled = series.copy()
        for late in range(1, TICKS + 1):
            older = np.concatenate([np.full(late, np.nan), series[:-late]])
            filled = np.where(np.isfinite(filled), filled, older)
        return filled[TICKS:]
