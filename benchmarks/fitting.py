"""A fit of ten parameters to four recordings, beside what one would do with a filter in Python and scipy alone."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

from scipy.optimize import OptimizeResult, minimize

from ballscrew.workspace import threads
from benchmarks.accuracy import FOLDER
from benchmarks.measure import Row, say, table
from benchmarks.shipped import Judged, stepped
from drivers.recordings import read_recording
from estimator.batch.trial import Trial
from estimator.batch.trials import trials_of
from estimator.fit.fit import Fit, fit
from estimator.fit.posterior import Posterior
from estimator.model import Model, Value
from estimator.record import Recording
from estimator.rig import Rig
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.work import Runs

RUNS = ("FS-20", "FS-5", "CS-10", "ES-2.5")
TEN = (
    "still_air.h", "rotating_convection.h", "nut_friction.power", "nut_friction.power_nut", "nut_body.g",
    "anchor_friction.power", "anchor_housing.g", "free_friction.power", "free_housing.g", "thermometers.tau",
)  # fmt: skip
EPS = 1e-5  # step of the finite differences, as a share of the parameter; scipy's own 1e-8 is lost in rounding


def only(model: Model, paths: Sequence[str]) -> Model:
    """The model with these parameters free, at the catalogue's defaults, and all others fixed as they are."""
    fixed = {path: replace(value, fixed=True) for path, value in model.values.items()}
    return model.with_values(fixed | {path: Value(model.param(path).value) for path in paths})


@dataclass(frozen=True)
class Naive:
    """One log-likelihood of all runs through the filter on filterpy, s, and what the optimiser needs of them."""

    evaluation_s: float
    apart: float
    search: OptimizeResult

    @property
    def seconds(self) -> float:
        """All of its evaluations."""
        return self.evaluation_s * self.search.nfev


def markdown() -> str:
    """Seconds of both."""
    rig, model = load_rig(FOLDER), only(load_model(FOLDER / "model.toml"), TEN)
    recordings = [read_recording(FOLDER / f"{name}.blf", rig) for name in RUNS]
    say("  fit")
    cpu, wall = time.process_time(), time.perf_counter()
    found = fit(model, Runs(rig, recordings))
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    say("  fit in threads")
    with threads() as workers:
        began = time.perf_counter()
        fit(model, Runs(rig, recordings, workers))
        shared = time.perf_counter() - began
    naive = _naive(model, found.model, rig, recordings)
    ticks = sum(len(recording) for recording in recordings)
    rows = [*_own(found, cpu, wall, shared), *_naively(naive, cpu, found)]
    return table(f"Engine: fit of {len(TEN)} parameters to {', '.join(RUNS)}, {ticks} ticks", rows, _says())


def _naive(model: Model, fitted: Model, rig: Rig, recordings: Sequence[Recording]) -> Naive:
    """Readings are refused for good by the fitted model's gate, as in the fit's own search."""
    say("  log-likelihood by the filter on filterpy")
    began, total = time.process_time(), 0.0
    for recording in recordings:
        judged = Judged(model, rig)
        stepped(judged, recording)
        total += judged.loglike
    seconds = time.process_time() - began
    ours = sum(Trial(model, rig, recording).loglike(model) for recording in recordings)
    say("  L-BFGS-B")
    with threads() as workers:
        posterior = Posterior(model, trials_of(fitted, Runs(rig, recordings, workers)), TEN)
        lo, hi = posterior.bounds
        search = minimize(
            lambda c: -posterior.value(c), posterior.start, method="L-BFGS-B", bounds=list(zip(lo, hi)),
            options={"eps": EPS, "maxfun": 10_000},
        )  # fmt: skip
    return Naive(seconds, abs(ours - total) / abs(total), search)


def _own(found: Fit, cpu: float, wall: float, shared: float) -> list[Row]:
    start, end = found.loglike
    ending = "converged" if found.converged else "not converged"
    return [
        Row("fit, one thread", f"{wall:.1f} s on the clock, {cpu:.1f} s CPU", wall, 60.0),
        Row("fit, recordings side by side in threads", f"{shared:.1f} s on the clock"),
        Row("its search", f"{found.steps} steps, {ending}, kept {found.kept}, process noise x {found.raised:.2f}"),
        Row("log posterior, open-loop start and end", f"{start:.1f}, {end:.1f}"),
    ]


def _naively(naive: Naive, cpu: float, found: Fit) -> list[Row]:
    search, times = naive.search, naive.seconds / cpu
    gradients = search.nfev // (len(TEN) + 1)
    return [
        Row("one log-likelihood of all runs by the filter on filterpy", f"{naive.evaluation_s:.1f} s CPU"),
        Row("relative difference of it from ours", f"{naive.apart:.1e}", naive.apart, 1e-9),
        Row("L-BFGS-B with finite differences", f"{search.nfev} log-likelihoods, {search.nit} steps: {search.message}"),
        Row("log posterior it reached, less ours", f"{-search.fun - found.loglike[1]:+.1f}"),
        Row("the naive fit", f"{naive.evaluation_s:.1f} s x {gradients} x {len(TEN) + 1} = {naive.seconds:.0f} s CPU"),
        Row("naive / ours, CPU", f"{times:.0f}", times, 20.0, least=True),
    ]


def _says() -> list[str]:
    return [
        "Ours is all of `estimator.fit.fit.fit`: open loop, likelihood, the choice between both, the check of the "
        "process noise. Begun from the catalogue's defaults, every other parameter fixed as shipped.",
        "The naive fit is not run but made up: the CPU time of one log-likelihood of the four runs by "
        "`estimator.filter.Filter`, from its innovations, measured in full, times the number of log-likelihoods that "
        f"scipy's L-BFGS-B with finite differences (step {EPS:g} of a parameter, p + 1 log-likelihoods a gradient) "
        "takes for the same posterior from the same start with the same scaling, counted by running it on our engine.",
        "That filter reads its inputs tick by tick, as live, which takes most of its time; "
        "with inputs read in blocks it took a third (2026-11-26: 109 times ours).",
    ]
