"""How a model misses some recordings open loop, and how that would move with parameters: sums of products.

    S[r] = sum over ticks and channels of c c',      c = (d(reading)/dp_1, ..., d(reading)/dp_k, misfit)

One pass over each recording serves every question that is linear in small changes of parameters: which of a hundred
candidates explains the misfit, with or without the model's own parameters fitted again, and how well that predicts a
recording left out. Parameters of an effect that is absent are taken at its null, so that nothing is fitted for it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from estimator.accuracy.reference import grown
from estimator.batch.open_loop import open_loop_misfit
from estimator.batch.trial import Trial
from estimator.batch.trials import Trials
from estimator.hypotheses.slopes import Column, slopes_beside, slopes_of
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.objective import GOOD_K, GOOD_UM, bodies_read


@dataclass(frozen=True)
class Moments:
    """Sums of one recording, over blocks (`Trial.block_s`): (B, k + 1, k + 1) each.

    heats   over thermometers, K2;  lengths: over the displacement, um2
    grows   of the elongation, um2: of the displacement's readings and those at rest, joined (`accuracy.reference`)
    heat_count, length_count, grown_count  readings in them
    independent  blocks, each as good as one independent reading of the displacement, and of each of so many bodies
    """

    heats: Array
    lengths: Array
    grows: Array
    heat_count: int
    length_count: int
    grown_count: int
    independent: float
    bodies: int = 1

    @cached_property
    def heat(self) -> Array:
        """Over thermometers of the whole recording, (k + 1, k + 1) K2."""
        return np.asarray(self.heats.sum(axis=0))

    @cached_property
    def length(self) -> Array:
        """Over the displacement, um2."""
        return np.asarray(self.lengths.sum(axis=0))

    @cached_property
    def grown(self) -> Array:
        """Of the elongation, um2."""
        return np.asarray(self.grows.sum(axis=0))

    @cached_property
    @np.errstate(over="ignore")
    def weighted(self) -> Array:
        """Mean squares of both families over what a good model leaves, times blocks: each family counts alike.

        The weights of `sensitivity.objective`, but for readings that were not taken: a displacement read only while
        driving counts here for the whole run, there for the time in which it was read.
        """
        of_heat, of_length = self.units
        return np.asarray(self.heat * of_heat + self.length * of_length)

    @property
    def units(self) -> tuple[float, float]:
        """What a K2 and a um2 of the sums count in `weighted`."""
        heat = self.independent * self.bodies / max(self.heat_count, 1) / GOOD_K**2
        return heat, self.independent / max(self.length_count, 1) / GOOD_UM**2

    @property
    def weight(self) -> float:
        """`weighted` of a misfit that is just good."""
        return self.independent * (self.bodies * (self.heat_count > 0) + (self.length_count > 0))


def moments(trials: Trials, model: Model, columns: Sequence[Column], own: Model | None = None) -> list[Moments]:
    """Moments of each recording."""
    return trials.each(lambda trial: moments_of(trial, model, columns, own))


@np.errstate(over="ignore", invalid="ignore")
def moments_of(trial: Trial, model: Model, columns: Sequence[Column], own: Model | None = None) -> Moments:
    """Moments of one recording; none that are finite where heat grows without bound, which no step is taken to.

    own  a model near this one, at whose values the slopes of its own parameters are taken; None: all of them at `model`
    """
    posed = trial.pose(model)
    found = slopes_beside(own, trial, posed, columns) if own else slopes_of(trial, posed, columns)
    readings = [*(slope.reading for slope in found), open_loop_misfit(trial, posed)]
    lengths = [*(slope.length[:, None] for slope in found), (grown(trial, posed, model).um - posed.run.grown)[:, None]]
    since, heat = trial.rest.time_s - trial.rest.time_s[0], trial.rig.is_thermometer
    starts = np.flatnonzero(np.diff(since // trial.block_s, prepend=-1.0))
    (heats, heat_count), (reads, read_count), (grows, grown_count) = (
        _by_block(*rows, starts) for rows in ((readings, heat), (readings, ~heat), (lengths, np.ones(1, dtype=bool)))
    )
    independent, bodies = max(1.0, float(since[-1]) / trial.block_s), bodies_read(trial.rig)
    return Moments(heats, reads, grows, heat_count, read_count, grown_count, independent, bodies)


def _by_block(columns: Sequence[Array], some: Array, starts: Array) -> tuple[Array, int]:
    """Products of columns (T, channels), `some` of the channels, summed over each block of ticks, where the last one is
    known; how many are."""
    at = np.flatnonzero(np.isfinite(columns[-1]) & some)
    rows = np.array([np.take(column, at) for column in columns])
    ends = np.searchsorted(at, [*(starts * len(some)), columns[-1].size])
    return np.array([part @ part.T for part in (rows[:, a:b] for a, b in pairwise(ends))]), len(at)
