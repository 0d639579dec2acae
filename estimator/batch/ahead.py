"""How the readings of a recording move with uncertain parameters, some ticks ahead of whoever judges them."""

import numpy as np

from estimator.batch.nominal import Nominal
from estimator.batch.system import System
from estimator.network.forcing import Drive, Ticks
from estimator.record import Array
from estimator.state.doubt import Doubt
from estimator.state.moves import Course, Moves

TICKS = 512  # worked out at a time: all of a long recording would not fit into memory


class Ahead:
    """The moves of one recording's open-loop run, in order of time.

    drive    from the sample with which the run began on;   heat, offset, outside  what a model makes of it
    """

    def __init__(
        self, doubt: Doubt, system: System, run: Nominal, drive: Drive, pushes: tuple[Array, Array, Array]
    ) -> None:
        self._doubt, self._system, self._run, self._drive = doubt, system, run, drive
        self._heat, self._offset, self._outside = pushes
        self._kept, self._first, self._end = list[Moves](), 0, 0

    def rows(self, ticks: slice) -> Moves:
        """Of some ticks; those before them are not asked for again."""
        if self._end < ticks.stop:
            left = slice(ticks.start - self._first, None)
            kept = [moves.rows(left) for moves in self._kept] if ticks.start < self._end else []
            while self._end < ticks.stop:
                kept.append(self._next())
            self._kept, self._first = [Moves.joined(kept) if kept[1:] else kept[0]], ticks.start
        return self._kept[0].rows(slice(ticks.start - self._first, ticks.stop - self._first))

    def _next(self) -> Moves:
        at = slice(self._end, min(self._end + TICKS, len(self._system.y)))
        after, ends = slice(at.start + 1, at.stop + 1), slice(at.start, at.stop + 1)
        run, self._end = self._run, at.stop
        ticks = Ticks(self._system.regime[at], self._heat[at], self._offset[after], self._outside[at])
        lagged = np.vstack([run.spot[:1], run.lagged])[ends]
        course = Course(run.z[ends], run.spot[ends], lagged, run.grown[at], run.late_share[at])
        return self._doubt.ahead(self._drive.rows(after), ticks, course)
