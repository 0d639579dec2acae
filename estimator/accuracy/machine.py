"""Whether a model is this machine's: the model alone against how far off it says that it may be.

A second ahead nothing tells: readings lead a filter along on any machine, and its process noise takes the rest for
chance. From the first sample on, by the inputs alone, each thermometer is off by

    y - y_open_loop ~ N(0, H P H' + R + M M')

P of a filter that fuses nothing, with start and process noise; M: how the reading moves per standard normal error of
the parameters (`state.doubt`). What parameters are off by lasts as long as a recording, so that the mean square of all
that in sd is one chi-square with one degree of freedom, not thousands. The median thermometer tells: one that fails, or
heat that is missing at one place, is not another machine.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np

from estimator.batch import batch
from estimator.batch.ahead import TICKS
from estimator.batch.coarse import serves
from estimator.batch.open_loop import open_loop_misfit
from estimator.batch.trial import Posed, Trial
from estimator.batch.trials import slowed
from estimator.faults.use import Use
from estimator.model import Model
from estimator.network.check import asks_for
from estimator.record import Array

CHANCE = 0.05  # that a model of this machine is taken for another's
LIMIT_SD = NormalDist().inv_cdf(1.0 - CHANCE / 2.0)


@dataclass(frozen=True)
class Match:
    """Whether a model is that of the machine which some recordings are of.

    off_sd  of each recording, how many times as far off as it says the model alone is: 1 where that is right; NaN
            where it cannot be told
    """

    off_sd: Sequence[float]

    @property
    def apart(self) -> list[int]:
        """Which recordings it is further off on than chance explains."""
        return [i for i, sd in enumerate(self.off_sd) if sd > LIMIT_SD]

    @property
    def own(self) -> bool | None:
        """False where it is so on most of them; None where nothing tells."""
        known = int(np.isfinite(self.off_sd).sum())
        return 2 * len(self.apart) <= known if known else None


def off_sd(model: Model, trial: Trial, use: Use) -> float:
    """Root of the mean square of what the model alone is off by, in its own sd, of the median thermometer.

    NaN where an input was broken or missing, for by wrong inputs every model is off; or where next to nothing was
    recorded.
    """
    unknown = any(asks_for(model, trial.rig, name) for name in use.never)
    if unknown or use.inputs or use.silent or use.travel or len(trial.rest) < 2 * serves(trial.rig):
        return float("nan")
    slow = slowed(trial, model)
    posed = slow.pose(model)
    squares = open_loop_misfit(slow, posed) ** 2 / _variance(slow, posed)
    columns = [column[np.isfinite(column)] for column in squares[:, slow.rig.is_thermometer].T]
    return float(np.sqrt(np.median([column.mean() for column in columns if len(column)] or [np.nan])))


def _variance(trial: Trial, posed: Posed) -> Array:
    """Of each reading around the model alone, (T, m)."""
    blind = replace(posed.system, muted=np.ones_like(trial.muted))
    sd = batch.compared(blind).sd
    doubt, T = trial.doubt(posed), len(sd)
    ahead = trial.ahead(posed, doubt)
    parts = (ahead.rows(slice(k, min(k + TICKS, T))).readings for k in range(0, T, TICKS))
    known = (doubt.known.doubtful(part, np.zeros(len(part))) for part in parts)
    return np.asarray(sd**2 + np.concatenate([np.vecdot(part, part) for part in known]))
