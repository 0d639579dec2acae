"""The compiled engine beside other packages and beside itself, one thread, one process."""

from collections.abc import Callable
from itertools import cycle

import numpy as np

from benchmarks import begin, fitting, shipped
from benchmarks.measure import Job, Row, Times, interleaved, ratio, say, table
from benchmarks.peers import Dynamax, Statsmodels, check_peers
from benchmarks.problem import Problem, make
from benchmarks.shipped import own_jobs, own_rows
from estimator.batch.batch import loglike, smoothed
from estimator.record import Array

ROUNDS = 9
FACTORS = np.linspace(0.95, 1.05, 7)


def synthetic() -> str:
    """22 states: ours, statsmodels and dynamax in the same rounds."""
    problem = make()
    steps, statsmodels, dynamax = len(problem.y), Statsmodels(problem), Dynamax(problem)
    times = interleaved(own_jobs(problem.system()) | _peer_jobs(problem, statsmodels, dynamax), ROUNDS)
    rows = [
        *_agreement(problem, statsmodels, dynamax),
        *_smoothers_agree(problem, dynamax),
        *own_rows(times, steps),
        *_beside_peers(times, steps),
    ]
    return table(f"Engine: {len(problem.x0)} states, {steps} steps, beside other packages", rows, _says(problem))


def _peer_jobs(problem: Problem, statsmodels: Statsmodels, dynamax: Dynamax) -> dict[str, Job]:
    """What is timed beside our own jobs; "new": with other parameters each time."""
    fresh, other = Statsmodels(problem), [problem.other(factor) for factor in FACTORS]
    return {
        "new": _each(other, lambda p: loglike(p.system())),
        "statsmodels": statsmodels.loglike,
        "statsmodels, new": _each(other, fresh.loglike_of),
        "dynamax": dynamax.loglike,
        "dynamax, new": _each(other, dynamax.loglike_of),
        "dynamax, smoother": dynamax.smoothed,
    }


def _says(problem: Problem) -> list[str]:
    return [
        f"15 temperatures ({problem.missing:.1%} missing) and a displacement on "
        f"{np.isfinite(problem.y[:, -1]).mean():.0%} of the steps, {len(problem.F)} regimes, an input that varies. "
        f"Medians of {ROUNDS} interleaved rounds, ratios of the same round, one thread.",
        "dynamax: compiled beforehand. statsmodels: its conventional filter, keeping nothing of single steps.",
    ]


def _each(problems: list[Problem], job: Callable[[Problem], float]) -> Callable[[], float]:
    """The job, with the next problem each time."""
    turn = cycle(problems)
    return lambda: job(next(turn))


def _agreement(problem: Problem, statsmodels: Statsmodels, dynamax: Dynamax) -> list[Row]:
    """How far the log-likelihoods are apart."""
    ours, other = loglike(problem.system()), problem.other(1.02)
    found = {
        "statsmodels": (ours, statsmodels.loglike()),
        "statsmodels, other parameters": (loglike(other.system()), Statsmodels(problem).loglike_of(other)),
        "dynamax": (ours, dynamax.loglike()),
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
    for study in (synthetic, shipped.markdown, fitting.markdown, begin.markdown):
        say(f"{study.__module__}")
        tables.append(study())
    return "\n".join(tables)
