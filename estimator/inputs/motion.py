"""What the screw's motion leaves behind: how long a run has lasted, whether it turns, and since when."""

from collections import deque
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from estimator.inputs.phase import turns
from estimator.record import Array
from estimator.screw import Screw

REMEMBERED = 500  # drives and rests; what lay further back has faded

POWER_W = 80.0  # that a drive at the reference speed brings into the screw
STILL, TURNING = 11.0, 25.0  # W/(m2 K) that air and bearings take off it at rest, and more at the reference speed
STEP, LEAST_K = 1.5, 0.5  # from one warmth to the next that is another regime at rest; the least of them

Stretch = tuple[bool, float]


@dataclass(frozen=True)
class Motion:
    """Columns (ticks, 1) over time.

    time_s   s since the first sample
    turning  1.0 while the screw turns, else 0.0
    since_s  s since it last started or stopped turning; before that since the first sample
    moved    1.0 from the first motion on
    before   drives and rests before these ticks: whether it turned, and for how many s
    warmth   K, how warm the motion so far, and what it began with, has left the screw on the whole, about, whatever the
             model
    """

    time_s: Array
    turning: Array
    since_s: Array
    moved: Array
    before: tuple[Stretch, ...] = ()
    tick_s: float = 1.0
    warmth: Array = field(default_factory=lambda: np.zeros((1, 1)))

    @classmethod
    def none(cls, ticks: int) -> "Motion":
        """The first instant of a run, at rest."""
        return cls(*np.zeros((4, ticks, 1)))

    @property
    def rest_K(self) -> Array:
        """The warmth in steps of half as much again while the screw stands, (ticks, 1), K; 0 while it turns."""
        steps = np.rint(np.log(np.maximum(self.warmth, LEAST_K) / LEAST_K) / np.log(STEP))
        return np.asarray(np.where(self.turning > 0, 0.0, LEAST_K * STEP**steps))

    def rows(self, at: slice) -> "Motion":
        """Some of the ticks."""
        turning, before = self.turning[: at.start, 0] > 0, list(self.before)
        for first, end in pairwise([0, *(np.flatnonzero(np.diff(turning)) + 1), len(turning)]):
            turned, seconds = bool(turning[first:end].any()), (end - first) * self.tick_s
            if before and before[-1][0] == turned:
                before[-1] = turned, before[-1][1] + seconds
            elif seconds:
                before.append((turned, seconds))
        columns = (self.time_s[at], self.turning[at], self.since_s[at], self.moved[at])
        warmth = self.warmth[at] if len(self.warmth) == len(self.turning) else self.warmth
        return Motion(*columns, tuple(before[-REMEMBERED:]), self.tick_s, warmth)

    def freshness(self, decay_s: float, recovery_s: float) -> Array:
        """1 after a long rest; fades while the screw turns and comes back while it stands: (ticks, 1).

        Of one tick with columns of seconds, (rows, 1): as many rows.

        turning: f <- f e^(-t / decay)        at rest: 1 - f <- (1 - f) e^(-t / recovery)
        """
        level: Any = 1.0
        for turned, seconds in self.before:
            level = _faded(level, turned, seconds, decay_s, recovery_s)
        turning = self.turning[:, 0] > 0
        ends = np.append(np.flatnonzero(np.diff(turning)) + 1, len(turning))
        parts, first = [], 0
        for end in ends:
            elapsed = np.arange(1, end - first + 1)[:, None] * self.tick_s
            parts.append(_faded(level, bool(turning[first]), elapsed, decay_s, recovery_s))
            level, first = parts[-1][-1], end
        return np.concatenate(parts)


def _faded(level: Any, turned: bool, seconds: Any, decay_s: Any, recovery_s: Any) -> Any:
    """Freshness some seconds later, from a level; both may be complex or arrays."""
    return level * np.exp(-seconds / decay_s) if turned else 1.0 - (1.0 - level) * np.exp(-seconds / recovery_s)


class MotionReader:
    """Follows the motion from tick to tick; `above_K`: how much warmer than the air the screw is at first."""

    def __init__(self, tick_s: float, screw: Screw | None = None, above_K: float = 0.0) -> None:
        self._tick, self._ticks, self._moved = tick_s, 0, False
        self._screw, self._warmth = screw, above_K
        self._stretches: deque[Stretch] = deque(maxlen=REMEMBERED)

    def read(self, omega: Array) -> Motion:
        """Motion of the next ticks, of speeds omega (ticks,) rad/s; call in order of time."""
        before, since = tuple(self._stretches), np.empty(len(omega))
        moves = turns(omega)
        for k, now in enumerate(moves):
            since[k] = self._follow(bool(now))
        turning = moves.astype(float)
        moved = np.maximum.accumulate(np.maximum(turning, float(self._moved)))
        self._moved = bool(moved[-1])
        time = (self._ticks + np.arange(len(omega))) * self._tick
        self._ticks += len(omega)
        columns = [column[:, None] for column in (time, turning, since, moved)]
        return Motion(columns[0], columns[1], columns[2], columns[3], before, self._tick, self._warm(omega))

    def _warm(self, omega: Array) -> Array:
        """C dw/dt = POWER s - (STILL + TURNING s^0.7) A w, s the relative speed: (ticks, 1)."""
        if self._screw is None:
            return np.zeros((len(omega), 1))
        speed = self._screw.relative_speed(omega)
        store = self._screw.density * self._screw.heat_capacity * self._screw.area * self._screw.length
        keep = np.exp(-self._tick * (STILL + TURNING * speed**0.7) * self._screw.surface / store)
        gain, found = self._tick * POWER_W * speed / (store * self._screw.cells), np.empty((len(omega), 1))
        for k in range(len(omega)):
            self._warmth = float(keep[k] * self._warmth + gain[k])
            found[k] = self._warmth
        return found

    def _follow(self, turning: bool) -> float:
        """One more tick: s since the motion last changed."""
        if self._stretches and self._stretches[-1][0] == turning:
            self._stretches[-1] = turning, self._stretches[-1][1] + self._tick
        else:
            self._stretches.append((turning, self._tick))
        return self._stretches[-1][1]
