"""What the screw's motion leaves behind: how long a run has lasted, whether it turns, and since when."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from estimator.inputs.phase import turns
from estimator.record import Array

REMEMBERED = 500  # drives and rests; what lay further back has faded

Stretch = tuple[bool, float]


@dataclass(frozen=True)
class Motion:
    """Columns (ticks, 1) over time.

    time_s   s since the first sample
    turning  1.0 while the screw turns, else 0.0
    since_s  s since it last started or stopped turning; before that since the first sample
    moved    1.0 from the first motion on
    before   drives and rests before these ticks: whether it turned, and for how many s
    """

    time_s: Array
    turning: Array
    since_s: Array
    moved: Array
    before: tuple[Stretch, ...] = ()
    tick_s: float = 1.0

    @classmethod
    def none(cls, ticks: int) -> Motion:
        """The first instant of a run, at rest."""
        return cls(*np.zeros((4, ticks, 1)))

    def rows(self, at: slice) -> Motion:
        """Some of the ticks."""
        turning, before = self.turning[: at.start, 0] > 0, list(self.before)
        for first, end in pairwise([0, *(np.flatnonzero(np.diff(turning)) + 1), len(turning)]):
            turned, seconds = bool(turning[first:end].any()), (end - first) * self.tick_s
            if before and before[-1][0] == turned:
                before[-1] = turned, before[-1][1] + seconds
            elif seconds:
                before.append((turned, seconds))
        columns = (self.time_s[at], self.turning[at], self.since_s[at], self.moved[at])
        return Motion(*columns, tuple(before[-REMEMBERED:]), self.tick_s)

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
    """Follows the motion from tick to tick."""

    def __init__(self, tick_s: float) -> None:
        self._tick, self._ticks, self._moved = tick_s, 0, False
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
        return Motion(columns[0], columns[1], columns[2], columns[3], before, self._tick)

    def _follow(self, turning: bool) -> float:
        """One more tick: s since the motion last changed."""
        if self._stretches and self._stretches[-1][0] == turning:
            self._stretches[-1] = turning, self._stretches[-1][1] + self._tick
        else:
            self._stretches.append((turning, self._tick))
        return self._stretches[-1][1]
