"""Fit a model's free parameters to recordings.

First least squares on the open-loop run (`follow`). From there the most likely parameters, or the most probable ones
where a table value is known, noise levels included (`optimiser`). A likelihood judges each second's prediction: what no
effect explains, small but lasting, can pull its optimum away from the parameters that predict best. So the likelihood's
optimum is kept only where it predicts ten minutes ahead as well, else the open-loop one; the fit says which.

A filter must not trust a model more than its errors allow: where ten blind minutes end further off than the process
noise says, it is raised (`tune`), and never lowered.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from estimator.accuracy.horizon import errors
from estimator.accuracy.noise_floor import Error
from estimator.batch.trials import Trials, trials_of
from estimator.errors import InputError, SetupError
from estimator.faults.use import Use
from estimator.fit.noise import noise_levels
from estimator.fit.open_loop_fit import Followed, follow, sandwich
from estimator.fit.optimiser import Optimiser, positive, told
from estimator.fit.posterior import Posterior
from estimator.fit.tune import scaled
from estimator.model import Model, Value
from estimator.record import Array
from estimator.work import Runs

AT_BOUND = 1e-3  # of the width between the bounds
ALIKE = 0.95  # a correlation worth naming
WEAK = 1e-9  # curvature, against its diagonal, of a direction that the data leave open
WORSE = 1.02  # an error ahead larger by this factor is worse


@dataclass(frozen=True)
class Fitted:
    """One fitted parameter: value and sd in `unit`; whether it ended at a bound, and whether the data determine it.

    like  the parameter that these recordings cannot tell it from, so that it was left where it was
    """

    path: str
    before: float
    value: float
    unit: str
    sd: float = float("nan")
    at_bound: bool = False
    determined: bool = False
    like: str = ""


@dataclass(frozen=True)
class Fit:
    """A fit's outcome.

    kept           "likelihood" or "open loop": whose parameters the model has;  noise levels are the likelihood's
    raised         factor by which the process noise had to be raised, 1: not at all
    alike          pairs of parameters whose errors correlate by more than 0.95, with the correlation
    loglike        log posterior of the open-loop parameters and of the likelihood's
    before, after  errors by horizon of the model as it came and as it left
    converged      whether the search came to its end; `stopped`: by the user
    uses           what was used of each recording
    """

    model: Model
    parameters: tuple[Fitted, ...]
    kept: str
    raised: float
    alike: tuple[tuple[str, str, float], ...]
    loglike: tuple[float, float]
    before: dict[str, Error]
    after: dict[str, Error]
    converged: bool
    stopped: bool
    steps: int
    uses: tuple[Use, ...]


@dataclass(frozen=True)
class Optimum:
    """Values to choose from: the model, covariance (p, p) of its free parameters, and sd (p,) by the data alone."""

    name: str
    model: Model
    paths: tuple[str, ...]
    covariance: Array
    alone: Array


def fit(model: Model, runs: Runs) -> Fit:
    """Fit all free parameters to all recordings; those that say nothing of any of them are an InputError."""
    paths = model.free()
    if not paths:
        raise SetupError(f"{model.name}: every parameter is fixed; nothing to fit")
    noise = Posterior(model, trials_of(model, runs), paths).noise
    mean = [path for path, level in zip(paths, noise, strict=True) if not level]
    followed = follow(model, runs, mean)
    left = followed.left
    if len(left) == len(paths):
        raise InputError(f"these recordings say nothing of {', '.join(left)}: free others, or record a longer drive")
    told_of = [path for path in paths if path not in left]
    posterior = Posterior(followed.model, trials_of(followed.model, runs), told_of)
    optimiser = Optimiser(posterior, told(runs.progress, "likelihood"))
    optimiser.stopped = followed.stopped
    if not optimiser.stopped:
        optimiser.run()
    found = [_likely(optimiser), *([_followed(followed, optimiser)] if followed.paths else [])]
    return _outcome(model, found, left, optimiser, runs)


def _likely(optimiser: Optimiser) -> Optimum:
    """The likelihood's optimum, its errors as the slopes of blocks of ten minutes scatter."""
    posterior, c = optimiser.posterior, optimiser.c
    information, steps = posterior.information(c), posterior.steps(c)
    bread = np.linalg.inv(positive(information.whole))
    blocks = information.blocks
    spread = np.einsum("bi,ij,bj->", blocks, bread, blocks) / max(len(bread), 1)
    cov = sandwich(bread, blocks, few=max(1.0, float(spread)))
    paths = tuple(each.path for each in posterior.coordinates)
    alone = _alone(information.data, bread, cov)
    return Optimum("likelihood", posterior.at(c), paths, cov * np.outer(steps, steps), alone * steps)


def _followed(followed: Followed, optimiser: Optimiser) -> Optimum:
    """The open-loop parameters, with the noise levels that are most likely beside them."""
    posterior = optimiser.posterior
    alone = _alone(followed.curvature, followed.bread, followed.covariance)
    levels = [each.path for each in posterior.coordinates if each.noise]
    if not levels:
        return Optimum("open loop", followed.model, followed.paths, followed.covariance, alone)
    search = Optimiser(Posterior(followed.model, posterior.trials, levels), optimiser.after_step)
    if not optimiser.stopped:
        search.run()
        optimiser.stopped = search.stopped
    own = _likely(search)
    both = block_diag(followed.covariance, own.covariance)
    return Optimum("open loop", own.model, (*followed.paths, *levels), both, np.append(alone, own.alone))


def _alone(curvature: Array, bread: Array, cov: Array) -> Array:
    """sd (p,) without any prior: as much wider than the curvature says as the sd with priors is."""
    wider = np.sqrt(np.diag(cov) / np.maximum(np.diag(bread), 1e-300))
    scale = np.sqrt(np.maximum(np.diag(curvature), 1e-300))
    rates, ways = np.linalg.eigh(curvature / np.outer(scale, scale))
    weak = rates <= WEAK
    open_ = (ways[:, weak] ** 2).sum(axis=1) > WEAK
    variance = (ways[:, ~weak] ** 2) @ (1.0 / rates[~weak])
    return np.asarray(np.where(open_, np.inf, np.sqrt(variance) / scale * wider))


def _outcome(model: Model, found: Sequence[Optimum], left: Mapping[str, str], optimiser: Optimiser, runs: Runs) -> Fit:
    trials = optimiser.posterior.trials
    judged = [errors(trials, candidate.model) for candidate in found]
    at = 1 if len(found) > 1 and _worse(judged[0], judged[1]) else 0
    kept = found[at]
    fitted = tuple(_fitted(model, kept, i) for i in range(len(kept.paths)))
    values = {f.path: Value(f.value, f.sd if np.isfinite(f.sd) else None) for f in fitted}
    fitted += tuple(
        Fitted(path, model[path], model[path], model.param(path).unit, like=like) for path, like in left.items()
    )
    fitted = tuple(sorted(fitted, key=lambda f: list(model.values).index(f.path)))
    about = {"rig": runs.rig.fingerprint(), "fitted_on": {r.name: r.fingerprint for r in runs.recordings}}
    better, raised = _raised(model.with_values(values), trials)
    better = replace(better, about={**model.about, **about})
    return Fit(
        better, fitted, kept.name, raised, alike(kept), (optimiser.first, optimiser.value), errors(trials, model),
        errors(trials, better), optimiser.converged, optimiser.stopped, optimiser.steps, trials.uses,
    )  # fmt: skip


def _raised(model: Model, trials: Trials) -> tuple[Model, float]:
    """The model with its process noise raised to what ten blind minutes show, and the factor (1: it was enough)."""
    fixed = [path for path in noise_levels(model, trials)["process"] if model.values[path].fixed]
    louder, factor = scaled(model, trials, fixed)
    return (louder, factor) if factor > 1 else (model, 1.0)


def _worse(a: dict[str, Error], b: dict[str, Error]) -> bool:
    """Whether a predicts clearly worse than b: ten minutes ahead, or open loop where recordings are shorter."""
    horizon = "ahead" if np.isfinite(b["ahead"].temperature_K) else "open_loop"
    x, y = a[horizon], b[horizon]
    return x.temperature_K > WORSE * y.temperature_K or x.elongation_um > WORSE * y.elongation_um


def _fitted(before: Model, kept: Optimum, i: int) -> Fitted:
    path = kept.paths[i]
    param, value = before.param(path), float(kept.model[path])
    width = param.hi - param.lo
    bound = min(value - param.lo, param.hi - value) < AT_BOUND * (width if np.isfinite(width) else abs(value))
    sd = float(np.sqrt(max(kept.covariance[i, i], 0.0))) if np.isfinite(kept.alone[i]) or param.sd else float("nan")
    known = kept.alone[i] < (param.sd or 0.5 * width)
    return Fitted(path, before[path], value, param.unit, sd, bool(bound), bool(known))


def alike(kept: Optimum) -> tuple[tuple[str, str, float], ...]:
    """Pairs whose errors go together."""
    sd = np.sqrt(np.maximum(np.diag(kept.covariance), 1e-300))
    rho = kept.covariance / np.outer(sd, sd)
    pairs = [(j, i) for i in range(len(rho)) for j in range(i) if abs(rho[i, j]) > ALIKE]
    return tuple((kept.paths[j], kept.paths[i], float(rho[i, j])) for j, i in pairs)
