"""Regimes: speeds and nut places that hold for a while, so that few transitions serve many ticks.

The nut's coverage changes every tick; heat follows it tick by tick. The conductances (nut contact, convection) take
means over the last minute of motion instead, of speed, its square, the time that it waits, and that the nut is at a
place; and the place where it is parked, and how warm the screw is then. A new regime begins when the speed has moved by
5 %, its unevenness by 15 % (the mean of the speed to the power of 0.67 by 5 %), the nut by 2 % of its length; what this
costs is measured in the tests (below 0.04 um).

The first strokes of a drive, and more so the longer ticks of a fit, begin regimes that lie as far off as these steps
allow, always to the same side. So after a minute, then two, four, ... minutes a regime is held against the mean of that
time, and makes room where it is off by more than a fifth of these steps. The middle of that time counts most, for it
holds no whole number of strokes, and no more does a minute: from then on a regime bears twice the steps.

While nothing is heard of the drive, or position and speed contradict each other, and until the lags of the thermometers
are those of what it does now, other regimes hold: the screw may have stood or turned, so that its heat is unknown.
"""

from collections import deque
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from estimator.inputs.phase import turns
from estimator.record import Array

WINDOW_S = 60.0
SETTLED_S = 60.0  # after the drive is heard again
SPEED_STEP = 0.05
UNEVEN_STEP = 0.15
COVERAGE_STEP = 0.02
CLOSE, SETTLED = 0.2, 2.0  # of these steps: off the mean of all strokes, and of a minute of them from then on
REMEMBERED = 500  # that may hold again; a machine that never does the same twice meets more in a day


NOTHING: Array = np.empty(0)


class Regime(NamedTuple):
    """What conductances go by.

    omega       rad/s, mean speed
    unevenness  mean of speed^2 over the square of the mean speed
    idle        share of the time in which the screw stands between its strokes
    coverage    (cells,) share of the time in which the nut covers each cell
    unknown     whether nothing is or has just been heard of the drive
    rest_K      as Inputs.rest_K
    """

    omega: float
    unevenness: float
    idle: float
    coverage: Array
    unknown: bool
    rest_K: float = 0.0

    def apart(self, other: "Regime") -> float:
        """How far it is from another, in steps of which one makes another regime."""
        if self.unknown != other.unknown or self.rest_K != other.rest_K or (self.omega == 0.0) != (other.omega == 0.0):
            return np.inf
        faster = abs(self.omega - other.omega) / (SPEED_STEP * (other.omega or 1.0))
        rougher = abs(self.unevenness - other.unevenness) / (UNEVEN_STEP * other.unevenness)
        waits = abs(self.idle - other.idle) / UNEVEN_STEP
        moved = np.abs(self.coverage - other.coverage).sum() / 2 / max(other.coverage.sum(), 1.0)
        return max(faster, rougher, waits, float(moved) / COVERAGE_STEP)


@dataclass
class Regimes:
    """The regimes met so far, and which one holds now. Causal: the same live and in review.

    forgets  whether those that cannot hold again leave no coverage behind
    """

    tick_s: float
    met: list[Regime] = field(default_factory=list)
    forgets: bool = False
    _current: int = -1
    _recent: dict[int, None] = field(default_factory=dict)
    _moving: deque[Array] = field(default_factory=deque)
    _sum: Array | float = 0.0  # of the last minute of motion
    _since: Array | float = 0.0  # of the ticks after the one in which it was last looked at, or another motion began
    _ticks: int = 0
    _due: int = 0  # of these ticks
    _most: float = 1.0
    _unsettled_s: float = 0.0
    _rests: bool | None = None  # whether unknown, where the last tick stood and has changed nothing

    def index(
        self, omega: float, coverage: Array, unknown: bool = False, unevenness: float = 1.0, idle: float = 0.0,
        rest_K: float = 0.0, again: bool = False,
    ) -> int:  # fmt: skip
        """Regime of the next tick, by speed (rad/s, with its unevenness and idle share) and coverage (cells,) by time.

        unknown  nothing was heard of the drive
        again    speed and coverage are those of the tick before: where that stood, most often there is nothing to do
        """
        self._unsettled_s = SETTLED_S if unknown else self._unsettled_s - self.tick_s
        unknown = self._unsettled_s > 0.0
        if again and self._rests == unknown:
            return self._current
        before = self._current, self._due, self._most, self._ticks
        found = self._next(omega, coverage, unknown, unevenness, idle, rest_K)
        unmoved = before == (self._current, self._due, self._most, self._ticks) and not turns(omega)
        self._rests = unknown if unmoved else None
        return found

    def _next(self, omega: float, coverage: Array, unknown: bool, unevenness: float, idle: float, rest_K: float) -> int:
        if turns(omega):
            self._moved(np.concatenate([[1.0, omega, unevenness * omega**2, idle], coverage]))
            now = _mean(self._sum, unknown)
        else:
            self._moving.clear()
            self._sum, now = 0.0, Regime(0.0, 1.0, 0.0, coverage, unknown, rest_K)
        apart = self.met[self._current].apart(now) if self.met else np.inf
        if self._ticks == self._due and apart <= SETTLED:
            long = _mean(self._since, unknown)
            close = self.met[self._current].apart(long) <= CLOSE
            self._watch(self._current if close else self._find(long, CLOSE), 2 * self._due, SETTLED)
        elif apart > SETTLED:
            self._watch(self._find(now, 1.0), max(1, round(WINDOW_S / self.tick_s)), 1.0)
        elif apart > self._most:
            self._current = self._find(now, 1.0)
        self._recent.pop(self._current, None)
        self._recent[self._current] = None
        return self._current

    def _moved(self, row: Array) -> None:
        if len(self._moving) * self.tick_s >= WINDOW_S:
            self._sum = self._sum - self._moving.popleft()
        self._moving.append(row)
        self._ticks += 1
        self._sum, self._since = self._sum + row, self._since + min(self._ticks, self._due + 1 - self._ticks) * row

    def _watch(self, regime: int, due: int, most: float) -> None:
        self._current, self._due, self._most = regime, due, most
        self._since, self._ticks = 0.0, 0

    def _find(self, now: Regime, steps: float) -> int:
        """The nearest regime of those that may hold again; a new one where none is as near."""
        apart, nearest = min(((self.met[r].apart(now), r) for r in self._recent), default=(np.inf, -1))
        if apart <= steps:
            return nearest
        if len(self._recent) >= REMEMBERED:
            oldest = next(iter(self._recent))
            del self._recent[oldest]
            if self.forgets:
                self.met[oldest] = self.met[oldest]._replace(coverage=NOTHING)
        self.met.append(now._replace(coverage=np.array(now.coverage, float)))
        return len(self.met) - 1


def _mean(sums: Array | float, unknown: bool) -> Regime:
    """From weighted sums of 1, speed, its square, the idle share and coverage."""
    (weight, omega, square, idle), cover = np.asarray(sums)[:4].tolist(), np.asarray(sums)[4:]
    return Regime(omega / weight, square * weight / omega**2, idle / weight, cover / weight, unknown)


def rows_of(regime: Array, r: int) -> Array | slice:
    """Which of the ticks of `regime` (K,) are in r, as a slice if that is one stretch: no copy then."""
    at = np.flatnonzero(regime == r)
    return slice(int(at[0]), int(at[-1]) + 1) if at[-1] - at[0] == len(at) - 1 else at
