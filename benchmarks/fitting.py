"""A fit of ten parameters to four recordings, beside what one would do with a filter in Python and scipy alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import OptimizeResult, minimize

from ballscrew.workers.processes import working
from benchmarks import paper_rig
from benchmarks.measure import Row, say, table, timed
from benchmarks.shipped import loglike_by_hand
from estimator.batch.trial import Trial
from estimator.batch.trials import Trials, trials_of
from estimator.fit.fit import Fit, fit
from estimator.model import Model, Value
from estimator.record import Array
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
    rig, model = paper_rig.rig(), only(paper_rig.model(), TEN)
    runs = Runs(rig, [paper_rig.recording(name) for name in RUNS])
    say("  fit")
    found, cpu, wall = timed(lambda: fit(model, runs))
    say("  fit in two processes")
    with working(2) as workers:
        _, _, shared = timed(lambda: fit(model, replace(runs, workers=workers)))
    naive = _naive(model, found.model, runs)
    ticks = sum(map(len, runs.recordings))
    rows = [*_own(found, cpu, wall, shared), *_naively(naive, cpu, found)]
    return table(f"Engine: fit of {len(TEN)} parameters to {', '.join(RUNS)}, {ticks} ticks", rows, _says())


def _naive(model: Model, fitted: Model, runs: Runs) -> Naive:
    """Readings are refused for good by the fitted model's gate, as in the fit's own search."""
    say("  log-likelihood by the filter on filterpy")
    total, seconds, _ = timed(lambda: sum(loglike_by_hand(model, runs.rig, each) for each in runs.recordings))
    ours = sum(Trial(model, runs.rig, recording).loglike(model) for recording in runs.recordings)
    say("  L-BFGS-B")
    with working() as workers:
        trials = trials_of(fitted, replace(runs, workers=workers))
        params, start = [model.param(path) for path in TEN], np.array([model[path] for path in TEN])
        search = minimize(
            lambda c: _unlikely(model, trials, c * start), np.ones(len(TEN)), method="L-BFGS-B",
            bounds=[(p.lo / x, p.hi / x) for p, x in zip(params, start)], options={"eps": EPS, "maxfun": 10_000},
        )  # fmt: skip
    return Naive(seconds, abs(ours - total) / abs(total), search)


def _unlikely(model: Model, trials: Trials, values: Array) -> float:
    """Minus the log posterior of the ten at these values."""
    there = model.with_values(dict(zip(TEN, values.tolist(), strict=True)))
    off = [(there[path] - p.value) / p.sd for path in TEN if (p := model.param(path)).sd]
    return 0.5 * float(np.dot(off, off)) - sum(trials.each(lambda trial: trial.loglike(there)))


def _own(found: Fit, cpu: float, wall: float, shared: float) -> list[Row]:
    ending = "converged" if found.converged else "not converged"
    return [
        Row("fit, one thread", f"{wall:.1f} s on the clock, {cpu:.1f} s CPU", wall, 15.0),
        Row(
            "fit, two processes, one / two on the clock",
            f"{shared:.1f} s, {wall / shared:.2f}",
            wall / shared,
            1.7,
            True,
        ),
        Row("its search", f"{found.steps} open-loop runs, {ending}, process noise x {found.raised.others:.2f}"),
    ]


def _naively(naive: Naive, cpu: float, found: Fit) -> list[Row]:
    search, times = naive.search, naive.seconds / cpu
    gradients = search.nfev // (len(TEN) + 1)
    return [
        Row("one log-likelihood of all runs by the filter on filterpy", f"{naive.evaluation_s:.1f} s CPU"),
        Row("relative difference of it from ours", f"{naive.apart:.1e}", naive.apart, 1e-9),
        Row("L-BFGS-B with finite differences", f"{search.nfev} log-likelihoods, {search.nit} steps: {search.message}"),
        Row("the naive fit", f"{naive.evaluation_s:.1f} s x {gradients} x {len(TEN) + 1} = {naive.seconds:.0f} s CPU"),
        Row("naive / ours, CPU", f"{times:.0f}", times, 20.0, least=True),
    ]


def _says() -> list[str]:
    return [
        "Ours is all of `estimator.fit.fit.fit`: the judging of readings, least squares open loop, the check of the "
        "process noise. Begun from the catalogue's defaults, every other parameter fixed as shipped.",
        "The naive fit is not run but made up: the CPU time of one log-likelihood of the four runs by "
        "`estimator.filter.Filter`, from its innovations, measured in full, times the number of log-likelihoods that "
        f"scipy's L-BFGS-B with finite differences (step {EPS:g} of a parameter, p + 1 log-likelihoods a gradient) "
        "takes for the likelihood of a tick ahead with the same priors from the same start, counted on our engine.",
        "That filter reads its inputs tick by tick, as live, which takes most of its time; "
        "with inputs read in blocks it took a third (2026-11-26: 109 times ours).",
    ]
