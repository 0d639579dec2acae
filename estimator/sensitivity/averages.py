"""How averages of readings move with heat in parts of a run: with all of it side by side, tick by tick."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.batch.trial import Posed
from estimator.record import Array
from estimator.state.open_loop import lag_filter


@dataclass(frozen=True)
class Averaged:
    """Which readings (T, m) are in which of N averages: `row` (T, m), -1: in none; `count` (N,)."""

    row: Array
    count: Array

    @classmethod
    def of(cls, cell: Array, known: Array) -> "tuple[Averaged, Array]":
        """Of readings that are `known` (T, m), those of one `cell` (T, m) together; and which cell each is of, (N,)."""
        cells, of_known = np.unique(cell[known], return_inverse=True)
        row = np.full(known.shape, -1)
        row[known] = of_known
        return cls(row, np.bincount(of_known)), cells

    def mean(self, values: Array) -> Array:
        """Of values (T, m), (N,)."""
        known = self.row >= 0
        return np.asarray(np.bincount(self.row[known], values[known], len(self.count)) / self.count)


def moves(posed: Posed, push: Sequence[Array] | Array, part: Array, averaged: Averaged) -> Array:
    """How averages move with what pushes the states by push[t] (n, C), K, in the ticks of each part alone, (N, B, C).

    part  (T,) which of B parts each tick is in, numbered as they begin: only those begun are carried
    """
    run, F, C = posed.run, posed.system.F, push[0].shape[1]
    keep, ramp = (each[:, None] for each in lag_filter(run.readings.tau, run.tick_s))
    begun = np.maximum.accumulate(part) + 1
    states, spots, lags = (np.zeros((size, begun[-1] * C)) for size in (F.shape[1], len(keep), len(keep)))
    total = np.zeros((len(averaged.count), begun[-1] * C))
    for t, (regime, own, end) in enumerate(zip(posed.system.regime.tolist(), part * C, begun * C, strict=True)):
        z, spot, lagged = states[:, :end], spots[:, :end], lags[:, :end]
        z[:] = F[regime] @ z
        z[:, own : own + C] += push[t]
        change = run.readings.rows @ z - spot
        lagged += (1.0 - keep) * (spot - lagged) + ramp * change
        spot += change
        read = np.flatnonzero(averaged.row[t] >= 0)
        total[averaged.row[t, read], :end] += lagged[read] - run.late_share[t, read, None] * change[read]
    return (total / averaged.count[:, None]).reshape(-1, begun[-1], C)
