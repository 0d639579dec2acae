"""The compiled engine beside other packages and beside itself, one thread, one process."""

from __future__ import annotations

from collections.abc import Callable
from itertools import cycle

import numpy as np

from benchmarks import begin, fitting, growth, shipped
from benchmarks.measure import Job, Row, Times, interleaved, ratio, say, table
from benchmarks.ours import own_jobs, own_rows
from benchmarks.peers import Dynamax, Statsmodels, check_peers, filterpy_loglike
from benchmarks.problem import Problem, make
from estimator.batch.batch import loglike, smoothed
from estimator.record import Array

ROUNDS = 9
SHARE = 1440  # steps that filterpy gets
FACTORS = np.linspace(0.95, 1.05, 7)


def synthetic() -> str:
    """22 states: ours, statsmodels, dynamax and filterpy in the same rounds."""
    problem = make()
    few, steps = problem.steps(SHARE), len(problem.y)
    statsmodels, dynamax = Statsmodels(problem), Dynamax(problem)
    jobs = own_jobs(problem.system()) | _peer_jobs(problem, statsmodels, dynamax, few)
    times = interleaved(jobs, ROUNDS)
    times["filterpy"] = times["filterpy"] / (SHARE / steps)
    rows = [
        *_agreement(problem, statsmodels, dynamax, few),
        *_smoothers_agree(problem, dynamax),
        *own_rows(times, steps),
        *_beside_peers(times, steps),
    ]
    return table(f"Engine: {len(problem.x0)} states, {steps} steps, beside other packages", rows, _says(problem))


def _peer_jobs(problem: Problem, statsmodels: Statsmodels, dynamax: Dynamax, few: Problem) -> dict[str, Job]:
    """What is timed beside our own jobs; "new": with other parameters each time."""
    fresh, other = Statsmodels(problem), [problem.other(factor) for factor in FACTORS]
    return {
        "new": _each(other, lambda p: loglike(p.system())),
        "statsmodels": statsmodels.loglike,
        "statsmodels, new": _each(other, fresh.loglike_of),
        "dynamax": dynamax.loglike,
        "dynamax, new": _each(other, dynamax.loglike_of),
        "dynamax, smoother": dynamax.smoothed,
        "filterpy": filterpy_loglike(few),
    }


def _says(problem: Problem) -> list[str]:
    return [
        f"15 temperatures ({problem.missing:.1%} missing) and a displacement on "
        f"{np.isfinite(problem.y[:, -1]).mean():.0%} of the steps, {len(problem.F)} regimes, an input that varies. "
        f"Medians of {ROUNDS} interleaved rounds, ratios of the same round, one thread.",
        f"filterpy: a loop in Python over predict and update, timed on {SHARE} steps and scaled to all. "
        "dynamax: compiled beforehand. statsmodels: its conventional filter, keeping nothing of single steps.",
    ]


def _each(problems: list[Problem], job: Callable[[Problem], float]) -> Callable[[], float]:
    """The job, with the next problem each time."""
    turn = cycle(problems)
    return lambda: job(next(turn))


def _agreement(problem: Problem, statsmodels: Statsmodels, dynamax: Dynamax, few: Problem) -> list[Row]:
    """How far the log-likelihoods are apart."""
    ours, ours_few, other = loglike(problem.system()), loglike(few.system()), problem.other(1.02)
    found = {
        "statsmodels": (ours, statsmodels.loglike()),
        "statsmodels, other parameters": (loglike(other.system()), Statsmodels(problem).loglike_of(other)),
        "dynamax": (ours, dynamax.loglike()),
        f"filterpy, {SHARE} steps": (ours_few, filterpy_loglike(few)()),
    }
    apart = {name: abs(a - b) / abs(a) for name, (a, b) in found.items()}
    rows = [Row("log-likelihood, ours", f"{ours:.6f}")]
    return rows + [
        Row(f"relative difference of the log-likelihood from {name}", f"{value:.1e}", value, 1e-9)
        for name, value in apart.items()
    ]


def _smoothers_agree(problem: Problem, dynamax: Dynamax) -> list[Row]:
    """Largest difference of smoothed means and variances, in standard deviations. dynamax adds 1e-9 to a diagonal."""
    found, (x, P) = smoothed(problem.system(), covariances=True), dynamax.smoothed()
    sd: Array = np.sqrt(found.var)
    means = float(np.abs((found.x - x) / sd).max())
    scale = sd[:, :, None] * sd[:, None, :]
    covariances = float(np.abs((found.cov - P) / scale).max())
    return [
        Row("smoothed means from dynamax, largest difference in sd", f"{means:.1e}", means, 0.02),
        Row("smoothed covariances from dynamax, largest difference in correlations", f"{covariances:.1e}"),
    ]


def _beside_peers(times: dict[str, Times], steps: int) -> list[Row]:
    names = {
        "statsmodels": "statsmodels",
        "dynamax": "dynamax",
        "filterpy": "filterpy",
        "new": "ours, new parameters",
        "statsmodels, new": "statsmodels, new parameters",
        "dynamax, new": "dynamax, new parameters",
    }
    ours, new, best = times["log-likelihood"], times["new"], "dynamax, smoother"
    full, variances = times["smoother, covariances"], times["smoother, variances"]
    return [
        *(Row(f"log-likelihood per step, {name}", times[key].per(steps)) for key, name in names.items()),
        ratio("log-likelihood, ours / statsmodels", ours, times["statsmodels"], 0.45),
        ratio("log-likelihood, ours / dynamax", ours, times["dynamax"]),
        ratio("log-likelihood, ours / filterpy", ours, times["filterpy"]),
        ratio("new parameters each time, ours / statsmodels", new, times["statsmodels, new"], 0.40),
        ratio("new parameters each time, ours / dynamax", new, times["dynamax, new"]),
        Row("filter and smoother per step, dynamax", times[best].per(steps)),
        ratio("filter and smoother with all covariances, ours / dynamax", full, times[best], 0.60, "wall"),
        ratio("filter and smoother with variances only, ours / dynamax", variances, times[best], None, "wall"),
    ]


def markdown() -> str:
    """All tables of this study."""
    check_peers()
    tables = []
    for study in (synthetic, shipped.markdown, growth.markdown, fitting.markdown, begin.markdown):
        say(f"{study.__module__}")
        tables.append(study())
    return "\n".join(tables)
