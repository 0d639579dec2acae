"""What the displacement says of parameters that no thermometer shows: of probes and bar, and of the expansion.

While driving all of them grow together, and what the model alone leaves is too rough to tell them apart. So the growth
is taken as the thermometers have it, by the filter without the displacement, and at rest as well, where the screw
shrinks while the bar still warms. The reading is direct there; a filter in use never sees it.

    r = y - estimate = g d + zero + e        d ~ N(0, C)

    d     errors of the model's parameters, and of each thermometer's own gain and lag
    g     how r moves with them, behind the filter (state/doubt.py)
    zero  one of all readings while driving, one of each rest: r and g less their means
    e     what lasts: s, alike for a block (`Trial.block_s`); it is what is left of r, or half of what a good model
          leaves, if more

Those that thermometers show keep their values: they are asked for as what else may be wrong.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from estimator.batch import batch
from estimator.batch.trial import Posed, Trial
from estimator.batch.trials import Trials
from estimator.inputs.phase import phases
from estimator.model import EXPANSION, Model
from estimator.record import Array
from estimator.sensitivity.objective import GOOD_UM
from estimator.state.doubt import Doubt

CHANNEL = "displacement"
LEAST_UM = 0.5 * GOOD_UM  # of s: no growth is known better by thermometers
ROUNDS = 3  # after which s is that of what is left


@dataclass(frozen=True)
class Left:
    """What the displacement of one recording leaves at some ticks.

    r, g    (k,) um and (k, p), less the means of their stretch; p: the parameters asked for, then own gains and lags
    own_sd  of each thermometer's own gain and lag
    hidden  (p,) which no thermometer shows
    """

    r: Array
    g: Array
    own_sd: Array
    hidden: Array


def calibrated(model: Model, trials: Trials, free: Sequence[str]) -> Model:
    """The model with those free parameters set that only the displacement shows, with their sd and correlations.

    As it came where no displacement is read, or nothing of that kind is uncertain.
    """
    paths = tuple(path for path, value in model.values.items() if value.sd)
    if not paths or not all(_is_read(trial) for trial in trials):
        return model
    found = trials.each(lambda trial: _left(trial, model, paths))
    hidden = np.all([each.hidden for each in found], axis=0)
    hidden[: len(paths)] &= np.array([path in free for path in paths])
    if not hidden.any():
        return model
    prior = scipy.linalg.block_diag(model.covariance(paths), np.diag(found[0].own_sd ** 2))
    best, after = _posterior(found, prior, trials[0].rig.tick_s / trials[0].block_s)
    known = prior.copy()
    known[hidden], known[:, hidden] = after[hidden], after[:, hidden]
    params = {path: model.param(path) for path, told in zip(paths, hidden) if told}
    moved = {path: np.clip(model[path] + best[paths.index(path)], p.lo, p.hi) for path, p in params.items()}
    return model.with_values(moved).known(paths, known[: len(paths), : len(paths)])


def _posterior(found: Sequence[Left], prior: Array, weight: float) -> tuple[Array, Array]:
    """Mean (p,) and covariance (p, p) of d; `weight`: of one reading, in independent ones."""
    r, g = np.concatenate([each.r for each in found]), np.vstack([each.g for each in found])
    A, b, s_um = weight * g.T @ g, weight * g.T @ r, GOOD_UM
    for _ in range(ROUNDS):
        after = prior @ np.linalg.inv(np.eye(len(prior)) + A @ prior / s_um**2)
        best = after @ b / s_um**2
        s_um = max(LEAST_UM, float(np.sqrt(((r - g @ best) ** 2).mean()))) if len(r) else GOOD_UM
    return best, after


def _is_read(trial: Trial) -> bool:
    """Whether the rig has a displacement, and something reads it."""
    return CHANNEL in trial.rig.channels and not trial.muted[:, trial.rig.index(CHANNEL)].all()


def _left(trial: Trial, model: Model, paths: Sequence[str]) -> Left:
    """What the displacement leaves of the growth that the thermometers have told."""
    posed, at = trial.pose(model), trial.rig.index(CHANNEL)
    doubt = trial.doubt(posed)
    grown, g, hidden = _followed(trial, _without(posed, at), doubt, at)
    own = len(doubt.paths)
    columns = [g[:, doubt.paths.index(p)] if p != EXPANSION else grown / (1.0 + model[p]) for p in paths]
    shown = np.array([p == EXPANSION or hidden[doubt.paths.index(p)] for p in paths] + [False] * len(doubt.own_sd))
    g = np.column_stack([*columns, g[:, own:]])
    held = np.where(posed.system.data.use[:, at], posed.system.y[:, at] - grown, np.nan)
    direct = trial.rest.inputs.get("displacement_direct", np.full(len(grown), np.nan)) - posed.offset[1:, at] - grown
    parts = list(_stretches(trial, held, direct))
    r = [left[ticks] - left[ticks].mean() for ticks, left in parts]
    return Left(
        np.concatenate([*r, np.empty(0)]),
        np.vstack([*(g[ticks] - g[ticks].mean(axis=0) for ticks, _ in parts), np.empty((0, g.shape[1]))]),
        doubt.own_sd,
        shown,
    )


def _without(posed: Posed, at: int) -> Posed:
    """A channel that is never fused."""
    muted = np.array(posed.system.muted)
    muted[:, at] = True
    return replace(posed, system=replace(posed.system, muted=muted))


def _followed(trial: Trial, posed: Posed, doubt: Doubt, at: int) -> tuple[Array, Array, Array]:
    """Elongation (T,) um, how a reading of it moves with doubts (T, p), and which no thermometer shows (q,)."""
    ahead, q, um, g, shown = trial.ahead(posed, doubt), len(doubt.paths), [], [], np.zeros(len(doubt.paths), dtype=bool)
    for chunk in batch.passes(posed.system, spread=False):
        moves = ahead.rows(chunk.ticks)
        grows = doubt.slopes(moves, chunk.gain)[1]
        grows[:, :q] += moves.readings[:, at, :q] - moves.elongation
        um.append((posed.state.elongation(moves.grown_um) * chunk.x).sum(axis=1))
        g.append(grows)
        read = np.delete(np.any(moves.readings[:, :, :q], axis=0), at, axis=0)
        shown |= read.any(axis=0) | np.any(moves.states, axis=(0, 1))
    return np.concatenate(um), np.concatenate(g), ~shown


def _stretches(trial: Trial, held: Array, direct: Array) -> Iterator[tuple[Array, Array]]:
    """Ticks that share a zero, with what is left: all of the drives; each rest, but for the tick in which it ends."""
    if len(drives := np.flatnonzero(np.isfinite(held))):
        yield drives, held
    for driving, ticks in phases(trial.rest):
        kept = ticks if ticks[-1] + 1 == len(held) else ticks[:-1]
        kept = kept[np.isfinite(direct[kept])]
        if not driving and len(kept):
            yield kept, direct
