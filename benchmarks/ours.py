"""What our engine does with a system, as jobs to be timed, and what each costs in filters."""

from __future__ import annotations

import numpy as np

from benchmarks.measure import Job, Row, Times, ratio
from estimator.batch import batch
from estimator.batch.system import System

FEW, MANY = 8, 32  # columns

TITLES = {
    "log-likelihood": "log-likelihood",
    "smoother, covariances": "filter and smoother with all covariances",
    "smoother, variances": "filter and smoother with variances only",
    "gradient": "value and gradient",
    "few": f"filter and {FEW} columns",
    "many": f"filter and {MANY} columns",
}


def own_jobs(system: System) -> dict[str, Job]:
    """The engine's functions on one system."""
    row = np.zeros(len(system.H), dtype=bool)
    row[-1] = True
    return {
        "log-likelihood": lambda: batch.loglike(system),
        "smoother, covariances": lambda: batch.smoothed(system, covariances=True),
        "smoother, variances": lambda: batch.smoothed(system),
        "gradient": lambda: batch.score(system, row),
        "few": _columns(system, FEW),
        "many": _columns(system, MANY),
    }


def own_rows(times: dict[str, Times], steps: int) -> list[Row]:
    """Cost per step, and in log-likelihoods."""
    one = times["log-likelihood"]
    column = (times["many"] - times["few"]) / (MANY - FEW)
    return [
        *(Row(f"{title}, ours, per step", times[key].per(steps)) for key, title in TITLES.items()),
        ratio("filter and smoother with all covariances / log-likelihood", times["smoother, covariances"], one),
        ratio("filter and smoother with variances only / log-likelihood", times["smoother, variances"], one),
        ratio("value and gradient / log-likelihood", times["gradient"], one, 4.0),
        ratio(f"one more column ({FEW} to {MANY}) / log-likelihood", column, one, 0.06),
    ]


def _columns(system: System, k: int) -> Job:
    """Gram matrix of k effects that put something into the states and the readings all the time."""
    dice = np.random.default_rng(k)
    B = 1e-3 * dice.standard_normal((*system.b.shape, k))
    D = 1e-3 * dice.standard_normal((*system.y.shape, k))
    return lambda: batch.gram(system, lambda ticks: (B[ticks], D[ticks]), k)
