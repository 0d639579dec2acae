"""A parameter run by run, each run by itself; and the strength of an effect, all its heats alike.

    minimise  d' S d + |R (p - p0)|^2 + sum of ((a - a0) / sd)^2,   d = (-(p - now) - U a, 1)

S are one run's sums (`hypotheses.moments`). What the fit knows of all parameters p is their prior; beside that the run
may be another one along some directions U, of which only tables are known: of one parameter, or of all powers of an
effect, as a bearing that wears has them. Readings are linear in parameters near the model's values: one step does.
"""

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
        inverse = _inverse(curvature)
        return float((inverse @ slope)[k]), float(np.sqrt(inverse[k, k]))

    def gain(self, one: Direction, shape: Array, beside: Sequence[Direction] = ()) -> float:
        """Twice the nats that a change of this shape (R,) explains of all runs together.

        Parameters are the same in all of them, which the courses, each run by itself, do not say: what all runs leave
        open alike counts once. So what two directions explain is compared by the same misfit. Those beside change from
        run to run.
        """
        k, along = len(self.paths), np.array([one.along.get(path, 0.0) for path in self.paths])
        curvature, slope = np.zeros((k + 1, k + 1)), np.zeros(k + 1)
        for sums, size in zip(self._sums, shape, strict=True):
            own = self._without(sums, beside)
            wide = np.hstack([np.eye(k), size * along[:, None]])
            curvature += wide.T @ own[:k, :k] @ wide
            slope += wide.T @ own[:k, k]
        curvature[:k, :k] += self._precision
        slope[:k] -= self._precision @ self._off
        taken = curvature[k, :k] @ _inverse(curvature[:k, :k])
        left = float(curvature[k, k] - taken @ curvature[:k, k])
        return float(slope[k] - taken @ slope[:k]) ** 2 / left if left > 0.0 else 0.0

    def _without(self, sums: Array, free: Sequence[Direction]) -> Array:
        """A run's sums where what changes from run to run is as it fits this run best."""
        if not free:
            return sums
        k = len(self.paths)
        U = np.array([[each.along.get(path, 0.0) for path in self.paths] + [0.0] for each in free])
        precision = np.diag([each.sd**-2.0 for each in free])
        off = np.zeros_like(U)
        off[:, k] = [(each.usual - each.now) * each.sd**-2.0 for each in free]
        across = U @ sums + off
        return np.asarray(sums - across.T @ _inverse(U @ sums @ U.T + precision) @ across)


def _inverse(curvature: Array) -> Array:
    """Its inverse, scaled; large where nothing tells of a parameter."""
    size = np.diag(curvature)
    scale = np.where(size > 0.0, size, 1.0) ** -0.5  # 0: of what neither the run nor anything else tells
    scaled = curvature * np.outer(scale, scale) + 1e-9 * np.eye(len(scale))
    return np.asarray(np.linalg.inv(scaled) * np.outer(scale, scale))
