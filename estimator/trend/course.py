"""A parameter run by run, each run by itself; and the strength of an effect, all its heats alike.

    minimise  d' S d + |R (p - p0)|^2 + sum of ((a - a0) / sd)^2,   d = (-(p - now) - U a, 1)

S are one run's sums (`hypotheses.moments`). What the fit knows of all parameters p is their prior; beside that the run
may be another one along some directions U, of which only tables are known: of one parameter, or of all powers of an
effect, as a bearing that wears has them. Readings are linear in parameters near the model's values: one step does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.hypotheses.moments import Moments
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.prior import belief

TOLD = 0.5  # of what its table says: what a run knows no better is not told by it
POWER = "W"


@dataclass(frozen=True)
class Direction:
    """What may change from run to run: `name` is `now` by the model, `along` what each parameter adds to one more.

    usual, sd  what tables say of it; sd inf: nothing
    """

    name: str
    unit: str
    now: float
    along: Mapping[str, float]
    usual: float
    sd: float


@dataclass(frozen=True)
class Course:
    """A direction over R runs: value (R,) and its sd (R,), NaN where a run tells nothing of it."""

    name: str
    unit: str
    value: Array
    sd: Array

    @property
    def known(self) -> Array:
        """Which runs tell something of it."""
        return np.flatnonzero(np.isfinite(self.sd))


def directions(model: Model) -> list[Direction]:
    """Each free parameter; and of an effect of several powers all of them in proportion, as a share of the model's."""
    found, powers = [], dict[str, list[str]]()
    for path in model.free():
        param, now = model.param(path), float(model[path])
        found.append(Direction(path, param.unit, now, {path: 1.0}, float(param.value), param.sd or np.inf))
        if param.unit == POWER and now:
            powers.setdefault(path.partition(".")[0], []).append(path)
    for effect, paths in powers.items():
        if len(paths) > 1:
            shares = [(model.param(path).sd or np.inf) / abs(float(model[path])) for path in paths]
            found.append(Direction(effect, "1", 1.0, {path: float(model[path]) for path in paths}, 1.0, min(shares)))
    return found


class Known:
    """What the sums of some runs and a model's fit say of its free parameters."""

    def __init__(self, model: Model, found: Sequence[Moments]) -> None:
        """`found`: sums of each run, with a column for each free parameter, in order."""
        self.paths = model.free()
        prior = belief(model, self.paths, [path for path in self.paths if model.values[path].sd])
        self._precision = prior.root.T @ prior.root
        self._off = np.array([float(model[path]) for path in self.paths]) - prior.middle
        self._sums = [each.weighted for each in found]

    def course(self, one: Direction, beside: Sequence[Direction] = ()) -> Course:
        """Of a direction, while some others change from run to run as well."""
        some = [one, *beside]
        U = np.array([[each.along.get(path, 0.0) for path in self.paths] for each in some]).T
        told = np.array([self._run(sums, U, some) for sums in self._sums])
        value, sd = one.now + told[:, 0], told[:, 1]
        seen = (sd < TOLD * one.sd) & self._believed(one)
        return Course(one.name, one.unit, np.where(seen, value, np.nan), np.where(seen, sd, np.nan))

    def _believed(self, one: Direction) -> bool:
        """Whether a fit or a table says anything of it that a run could differ from."""
        return any(self._precision[i, i] > 0.0 for i, path in enumerate(self.paths) if path in one.along)

    def _run(self, sums: Array, U: Array, some: Sequence[Direction]) -> tuple[float, float]:
        """By how much the first direction is another one in a run, and its sd."""
        k, widths = len(self.paths), np.array([each.sd for each in some])
        wide = np.hstack([np.eye(k), U])
        curvature = wide.T @ sums[:k, :k] @ wide
        curvature[:k, :k] += self._precision
        curvature[k:, k:] += np.diag(widths**-2.0)
        slope = wide.T @ sums[:k, k]
        slope[:k] -= self._precision @ self._off
        slope[k:] += np.array([each.usual - each.now for each in some]) * widths**-2.0
        size = np.diag(curvature)
        scale = np.where(size > 0.0, size, 1.0) ** -0.5  # 0: of what neither the run nor anything else tells
        scaled = curvature * np.outer(scale, scale) + 1e-9 * np.eye(len(scale))
        inverse = np.linalg.inv(scaled) * np.outer(scale, scale)
        return float((inverse @ slope)[k]), float(np.sqrt(inverse[k, k]))
