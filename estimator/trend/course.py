"""A parameter run by run, each run by itself.

value   minimises d' S d + |R (p - p0)|^2 over all parameters, from one run's sums S (`hypotheses.moments`); what
        the fit knows of them is their prior, but of this one only its table is
change  of the readings is linear in parameters near the model's values: one step does
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.hypotheses.ground import Ground
from estimator.hypotheses.moments import Moments
from estimator.hypotheses.panel import Panel
from estimator.hypotheses.slopes import Column
from estimator.model import Model
from estimator.record import Array

TOLD = 0.5  # of what its table says: a parameter that a run knows no better is not told by it


@dataclass(frozen=True)
class Course:
    """One parameter "effect.param" of R runs: value (R,) and its sd (R,), NaN where a run tells nothing of it."""

    path: str
    unit: str
    value: Array
    sd: Array

    @property
    def known(self) -> Array:
        """Which runs tell something of it."""
        return np.flatnonzero(np.isfinite(self.sd))


def courses(model: Model, found: Sequence[Moments], paths: Sequence[str], moved: Sequence[str] = ()) -> list[Course]:
    """Of these parameters; those `moved` change from run to run beside each, as the run says."""
    learned = frozenset(path for path in model.free() if model.values[path].sd)
    ground = Ground(model, tuple(model.free()), learned - {*moved})
    return [_course(ground.freed(path), found, path) for path in paths]


def _course(ground: Ground, found: Sequence[Moments], path: str) -> Course:
    model, at = ground.model, ground.paths.index(path)
    columns = [Column(model, other) for other in ground.paths]
    known, param = ground.belief(model, ground.paths), model.param(path)
    value, sd = np.empty(len(found)), np.empty(len(found))
    for i, of_run in enumerate(found):
        judged = Panel(columns, [of_run], known).judge()
        value[i], sd[i] = model[path] + judged.change[at], judged.sd[at]
    told = sd < TOLD * (param.sd or np.inf)
    return Course(path, param.unit, np.where(told, value, np.nan), np.where(told, sd, np.nan))
