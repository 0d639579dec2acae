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

from estimator.accuracy.reference import grown, slope
from estimator.batch.open_loop import open_loop_misfit, where_measured
from estimator.batch.trial import Posed, Trial
from estimator.batch.trials import Trials
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.objective import BLOCK_S, GOOD_K, GOOD_UM
from estimator.sensitivity.sensitivity import NominalColumn, nominal_column
from estimator.sensitivity.tangent import tangent


@dataclass(frozen=True)
class Column:
    """One parameter "effect.param" of a model, which says where its effect sits."""

    model: Model
    path: str


@dataclass(frozen=True)
class Moments:
    """Sums of one recording, (k + 1, k + 1) each: over thermometers, K2, and over the displacement, um2.

    grown   of the elongation, um2: of the displacement's readings and those at rest, joined (`accuracy.reference`)
    heat_count, length_count, grown_count  readings in them
    blocks  stretches of ten minutes, each as good as one independent reading
    """

    heat: Array
    length: Array
    grown: Array
    heat_count: int
    length_count: int
    grown_count: int
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
    stack, lengths = np.empty((len(columns) + 1, *misfit.shape)), np.empty((len(columns) + 1, len(misfit)))
    for row, length, column in zip(stack, lengths, columns, strict=False):
        moved = nominal_column(trial, posed, tangent(trial, posed, column.model, column.path))
        row[:], length[:] = where_measured(moved.reading, trial), slope(_reads(moved, trial, posed), trial)
    stack[-1], lengths[-1] = misfit, grown(trial, posed, model) - posed.run.grown
    heat = trial.rig.is_thermometer
    rows = [stack[:, :, family][:, np.isfinite(misfit[:, family])] for family in (heat, ~heat)]
    rows.append(lengths[:, np.isfinite(lengths[-1])])
    heats, reads, grows = (row @ row.T for row in rows)
    heat_count, read_count, grown_count = (row.shape[1] for row in rows)
    blocks = max(1.0, float(trial.rest.time_s[-1] - trial.rest.time_s[0]) / BLOCK_S)
    return Moments(heats, reads, grows, heat_count, read_count, grown_count, blocks)


def _reads(moved: NominalColumn, trial: Trial, posed: Posed) -> Array:
    """How what the displacement would read moves, (T,); the growth, where the model does not read it."""
    rig, known = trial.rig, np.isfinite(posed.forcing.readings.sd)
    if "displacement" in rig.channels and known[rig.index("displacement")]:
        return moved.reading[:, rig.index("displacement")]
    return moved.grown
