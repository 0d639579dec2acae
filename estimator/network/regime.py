"""Regimes: speeds and nut places that hold for a while, so that few transitions serve many ticks.

The nut's coverage changes every tick; heat follows it tick by tick. The conductances (nut contact, convection) take the
trailing mean of speed and coverage over the last minute of motion instead, and the coverage as it is when parked. A new
regime begins when that mean has moved by 5 % in speed or by 2 % of the nut's length in coverage; what this costs is
measured in the tests (below 0.04 um).

While nothing is heard of the drive, or position and speed contradict each other, and until the lags of the thermometers
are those of what it does now, other regimes hold: the screw may have stood or turned, so that its heat is unknown.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from estimator.inputs.phase import turns
from estimator.record import Array

WINDOW_S = 60.0
SETTLED_S = 60.0  # after the drive is heard again
SPEED_STEP = 0.05
COVERAGE_STEP = 0.02
REMEMBERED = 500  # that may hold again; a machine that never does the same twice meets more in a day


NOTHING: Array = np.empty(0)


@dataclass
class Regimes:
    """The regimes met so far, and which one holds now. Causal: the same live and in review.

    unknown  whether nothing is or has just been heard of the drive
    forgets  whether those that cannot hold again leave no coverage behind
    """

    tick_s: float
    omega: list[float] = field(default_factory=list)
    coverage: list[Array] = field(default_factory=list)
    unknown: list[bool] = field(default_factory=list)
    forgets: bool = False
    _current: int = -1
    _recent: dict[int, None] = field(default_factory=dict)
    _moving: deque[tuple[float, Array]] = field(default_factory=deque)
    _sum: Array | float = 0.0
    _speeds: float = 0.0
    _unsettled_s: float = 0.0

    def index(self, omega: float, coverage: Array, unknown: bool = False) -> int:
        """Regime of the next tick, (omega rad/s, coverage (cells,)); `unknown`: nothing was heard of the drive."""
        self._unsettled_s = SETTLED_S if unknown else self._unsettled_s - self.tick_s
        mean = *self._mean(omega, coverage), self._unsettled_s > 0.0
        if self._current < 0 or not self._fits(self._current, *mean):
            self._current = self._find(*mean)
        self._recent.pop(self._current, None)
        self._recent[self._current] = None
        return self._current

    def _mean(self, omega: float, coverage: Array) -> tuple[float, Array]:
        if not turns(omega):
            self._moving.clear()
            self._sum = self._speeds = 0.0
            return 0.0, coverage
        if len(self._moving) * self.tick_s >= WINDOW_S:
            speed, covered = self._moving.popleft()
            self._speeds, self._sum = self._speeds - speed, self._sum - covered
        self._moving.append((omega, coverage))
        self._speeds, self._sum = self._speeds + omega, self._sum + coverage
        return self._speeds / len(self._moving), self._sum / len(self._moving)

    def _fits(self, regime: int, omega: float, coverage: Array, unknown: bool) -> bool:
        held = self.omega[regime]
        if self.unknown[regime] != unknown or (held == 0.0) != (omega == 0.0) or abs(held - omega) > SPEED_STEP * omega:
            return False
        moved = np.abs(self.coverage[regime] - coverage).sum() / 2
        return bool(moved <= COVERAGE_STEP * max(float(coverage.sum()), 1.0))

    def _find(self, omega: float, coverage: Array, unknown: bool) -> int:
        for regime in sorted(self._recent):
            if self._fits(regime, omega, coverage, unknown):
                return regime
        if len(self._recent) >= REMEMBERED:
            oldest = next(iter(self._recent))
            del self._recent[oldest]
            if self.forgets:
                self.coverage[oldest] = NOTHING
        self.omega.append(omega)
        self.coverage.append(np.array(coverage))
        self.unknown.append(unknown)
        return len(self.omega) - 1
