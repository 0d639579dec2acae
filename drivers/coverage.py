"""Which share of its way the nut spent over each cell: a box of the nut's length, moved exactly between frames.

While the nut's centre runs evenly from a to b, the cover of a point x is a ramp up over [a - h, b - h] and a ramp down
over [a + h, b + h], h half the nut. A cell's share is the integral of that over the cell: second sums over the ramps'
kinks. So N frames and K ticks cost N + K * cells, and 20 Hz frames give the same smooth profile as 100 Hz.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimator.rig import Screw

Array = NDArray[np.float64]

_STANDS = 1e-3  # cells: a shorter way is a stand


def covered(
    screw: Screw, length_mm: float, way: tuple[Array, Array], weight: Array, row: NDArray[np.intp], rows: int
) -> Array:
    """Cover of each cell, (rows, cells), 0 ... 1: the weighted mean over the ways of a row; 0 in a row without weight.

    way     (N,), (N,)  nut centre at begin and end of each way, mm
    weight  (N,)        time or angle of each way
    row     (N,)        tick of each way
    """
    cell = screw.length * 1e3
    low = (np.minimum(*way) - screw.from_mm) / cell
    high = (np.maximum(*way) - screw.from_mm) / cell
    half = length_mm / 2 / cell
    total = np.bincount(row, weight, rows)
    share = np.divide(weight, total[row], out=np.zeros_like(weight), where=total[row] > 0)
    sums = _Sums(rows, screw.cells)
    runs = high - low > _STANDS
    for side, sign in ((-half, 1.0), (half, -1.0)):
        slope = sign * share[runs] / (high - low)[runs]
        sums.kink(low[runs] + side, slope, row[runs])
        sums.kink(high[runs] + side, -slope, row[runs])
        sums.jump((low + high)[~runs] / 2 + side, sign * share[~runs], row[~runs])
    return sums.cells()


class _Sums:
    """Sums of kinks (slope changes) and jumps of a profile, per row and cell; cells are 1 wide."""

    def __init__(self, rows: int, cells: int) -> None:
        self.shape = (rows, cells + 2)  # one bin before the screw, one behind
        self.slope = np.zeros(self.shape)
        self.moment = np.zeros(self.shape)
        self.step = np.zeros(self.shape)
        self.inside = np.zeros(self.shape)

    def kink(self, at: Array, slope: Array, row: NDArray[np.intp]) -> None:
        """The profile's slope changes by `slope` at `at`."""
        where, rest = self._bins(at, row)
        self._add(self.slope, where, slope)
        self._add(self.moment, where, slope * at)
        self._add(self.inside, where, slope * rest**2 / 2)

    def jump(self, at: Array, height: Array, row: NDArray[np.intp]) -> None:
        """The profile changes by `height` at `at`."""
        where, rest = self._bins(at, row)
        self._add(self.step, where, height)
        self._add(self.inside, where, height * rest)

    def cells(self) -> Array:
        """Mean of the profile in each cell, (rows, cells)."""
        before = [np.cumsum(sums, axis=1)[:, :-2] for sums in (self.slope, self.moment, self.step)]
        centre = np.arange(self.shape[1] - 2) + 0.5
        return np.clip(before[0] * centre - before[1] + before[2] + self.inside[:, 1:-1], 0.0, 1.0)

    def _bins(self, at: Array, row: NDArray[np.intp]) -> tuple[NDArray[np.intp], Array]:
        place = np.clip(np.floor(at), -1, self.shape[1] - 2).astype(np.intp) + 1
        return row * self.shape[1] + place, place - at

    def _add(self, sums: Array, where: NDArray[np.intp], what: Array) -> None:
        sums += np.bincount(where, what, sums.size).reshape(self.shape)
