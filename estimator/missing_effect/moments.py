"""How a model misses some recordings open loop, and how that would move with parameters: sums of products.

    S[r] = sum over ticks and channels of c c',      c = (d(reading)/dp_1, ..., d(reading)/dp_k, misfit)

One pass over each recording serves every question that is linear in small changes of parameters: which of a hundred
candidates explains the misfit, with or without the model's own parameters fitted again, and how well that predicts a
recording left out. Parameters of an effect that is absent are taken at its null, so that nothing is fitted for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.batch.open_loop import open_loop_misfit
from estimator.batch.trial import Trial
from estimator.batch.trials import Trials
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.objective import BLOCK_S, GOOD_K, GOOD_UM, reading_slope


@dataclass(frozen=True)
class Column:
    """One parameter "effect.param" of a model, which says where its effect sits."""

    model: Model
    path: str


@dataclass(frozen=True)
class Moments:
    """Sums of one recording, (k + 1, k + 1) each: over thermometers, K2, and over the displacement, um2.

    heat_count, length_count  readings in them
    blocks  stretches of ten minutes, each as good as one independent reading
    """

    heat: Array
    length: Array
    heat_count: int
    length_count: int
    blocks: float

    @property
    def weighted(self) -> Array:
        """Mean squares of both families over what a good model leaves, times blocks: each family counts alike.

        The weights of `sensitivity.objective`, but for readings that were not taken: a displacement read only while
        driving counts here for the whole run, there for the time in which it was read.
        """
        heat = self.heat / max(self.heat_count, 1) / GOOD_K**2
        length = self.length / max(self.length_count, 1) / GOOD_UM**2
        return (heat + length) * self.blocks

    @property
    def weight(self) -> float:
        """`weighted` of a misfit that is just good."""
        return self.blocks * ((self.heat_count > 0) + (self.length_count > 0))


def moments(trials: Trials, model: Model, columns: Sequence[Column]) -> list[Moments]:
    """Moments of each recording."""
    return trials.each(lambda trial: moments_of(trial, model, columns))


def moments_of(trial: Trial, model: Model, columns: Sequence[Column]) -> Moments:
    """Moments of one recording."""
    posed = trial.pose(model)
    misfit = open_loop_misfit(trial, posed)
    known = np.isfinite(misfit)
    stack = np.empty((len(columns) + 1, *misfit.shape))
    for row, column in zip(stack, columns, strict=False):
        row[:] = reading_slope(trial, posed, column.model, column.path)
    stack[-1] = misfit
    heat = trial.rig.is_thermometer
    sums = []
    for family in (heat, ~heat):
        rows = stack[:, :, family][:, known[:, family]]
        sums.append((rows @ rows.T, rows.shape[1]))
    time_s = trial.rest.time_s
    blocks = max(1.0, float(time_s[-1] - time_s[0]) / BLOCK_S)
    return Moments(sums[0][0], sums[1][0], sums[0][1], sums[1][1], blocks)
