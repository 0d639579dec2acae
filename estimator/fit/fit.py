"""Fit a model's free parameters to recordings.

Least squares on the open-loop run, priors included (`follow`), then what only the displacement shows by the filter
(`calibrated`), then noise levels that are free by likelihood, all else held (`likely`). A likelihood judges each
second's prediction: what no effect explains, small but lasting, pulls its parameters away from those that predict best;
so it finds noise alone.

A filter must not trust readings more than they scatter, nor a model more than its errors allow: where successive
readings differ by more than their noise says, that is raised (`scattered`); and where ten blind minutes end further off
than the process noise says, or thermometers that it does not see, this is (`tune`). Neither is lowered.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from estimator.accuracy.horizon import errors
from estimator.accuracy.noise_floor import Error
from estimator.batch.trials import Trials, trials_of
from estimator.errors import InputError, SetupError
from estimator.faults.use import Use
from estimator.fit.calibration import calibrated
from estimator.fit.likelihood import Likelihood, Likely, likely
from estimator.fit.noise import noise_levels, scattered
from estimator.fit.open_loop_fit import Followed, follow
from estimator.fit.tune import Factors, scaled
from estimator.model import Model
from estimator.record import Array
from estimator.work import Runs, one_thread

AT_BOUND = 0.1  # sd
ALIKE = 0.95  # a correlation worth naming
TELLING = 0.9  # of the prior's sd: a parameter known no better is the table's


@dataclass(frozen=True)
class Fitted:
    """One parameter: value and sd in `unit`; whether it ended at a bound, and whether the data say more than the table.

    sd    NaN where it was left as it was: without influence, ...
    like  ... or because these recordings cannot tell it from this one
    """

    path: str
    before: float
    value: float
    unit: str
    sd: float = float("nan")
    at_bound: bool = False
    determined: bool = False
    like: str = ""

    def __str__(self) -> str:
        return f"{self.path:32} {self.before:.5g} -> {self.value:.5g} +- {self.sd:.2g} {self.unit}"


@dataclass(frozen=True)
class Fit:
    """A fit's outcome.

    scatter        factor by which the thermometers' noise had to be raised, 1: not at all
    raised         factors by which the process noise had to be, likewise
    alike          pairs of parameters whose errors correlate by more than 0.95, with the correlation
    before, after  errors by horizon of the model as it came and as it left
    converged      whether the search came to its end; `stopped`: by the user;  steps: open-loop runs it took
    uses           what was used of each recording
    """

    model: Model
    parameters: tuple[Fitted, ...]
    scatter: float
    raised: Factors
    alike: tuple[tuple[str, str, float], ...]
    before: dict[str, Error]
    after: dict[str, Error]
    converged: bool
    stopped: bool
    steps: int
    uses: tuple[Use, ...]

    def __repr__(self) -> str:
        """Its parameters, then the errors of the model alone before and after."""
        alone = f"the model alone: {self.before['open_loop']} -> {self.after['open_loop']}"
        return "\n".join([*map(str, self.parameters), alone])


@one_thread
def fit(model: Model, runs: Runs, learned: bool = False) -> Fit:
    """Fit all free parameters to all recordings; those that say nothing of any of them are an InputError.

    learned  whether what the model knows of its parameters, from recordings fitted before, is their prior
    """
    paths = model.free()
    if not paths:
        raise SetupError(f"{model.name}: every parameter is fixed; nothing to fit")
    followed = follow(model, runs, paths, learned)
    if len(followed.left) == len(paths):
        named = ", ".join(followed.left)
        raise InputError(f"these recordings say nothing of {named}: free others, or record a longer drive")
    trials = trials_of(followed.model, runs)
    found = Likely(followed.model)
    if followed.levels and not followed.stopped:
        found = likely(found.model, trials, followed.levels, "likelihood", runs.progress)
    return _outcome(model, found, followed, trials, runs)


def _outcome(model: Model, found: Likely, followed: Followed, trials: Trials, runs: Runs) -> Fit:
    paths = (*followed.paths, *followed.levels)
    own = Likelihood(found.model, trials, followed.levels).covariance() if followed.levels else np.zeros((0, 0))
    better = found.model.known(paths, scipy.linalg.block_diag(followed.covariance, own))
    better = calibrated(better, trials, followed.paths)
    covariance = better.covariance(paths)
    fitted = {path: _fitted(model, better, path, covariance[i, i]) for i, path in enumerate(paths)}
    for path, like in followed.left.items():
        fitted[path] = Fitted(path, model[path], model[path], model.param(path).unit, like=like)
    about = {"rig": runs.rig.fingerprint(), "fitted_on": {r.name: r.fingerprint for r in runs.recordings}}
    better, scatter = scattered(replace(better, about={**better.about, **about}), trials)
    better, raised = _raised(better, trials)
    told = tuple(fitted[path] for path in model.values if path in fitted)
    return Fit(
        better, told, scatter, raised, alike(paths, covariance),
        errors(trials, model), errors(trials, better), followed.converged and found.converged,
        followed.stopped or found.stopped, followed.runs, trials.uses,
    )  # fmt: skip


def _raised(model: Model, trials: Trials) -> tuple[Model, Factors]:
    """The model with its process noise raised to what is seen where it is blind, and the factors; 1: it was enough."""
    fixed = [path for path in noise_levels(model, trials)["process"] if model.values[path].fixed]
    return scaled(model, trials, fixed, lowest=0.0)


def _fitted(before: Model, after: Model, path: str, variance: float) -> Fitted:
    param, value, sd = before.param(path), float(after[path]), float(np.sqrt(variance))
    bound = min(value - param.lo, param.hi - value) < AT_BOUND * sd
    known = sd < (TELLING * param.sd if param.sd else 0.5 * (param.hi - param.lo))
    return Fitted(path, before[path], value, param.unit, sd, bool(bound), bool(known))


def alike(paths: tuple[str, ...], covariance: Array) -> tuple[tuple[str, str, float], ...]:
    """Pairs whose errors go together."""
    sd = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    rho = covariance / np.outer(sd, sd)
    pairs = [(j, i) for i in range(len(rho)) for j in range(i) if abs(rho[i, j]) > ALIKE]
    return tuple((paths[j], paths[i], float(rho[i, j])) for j, i in pairs)
