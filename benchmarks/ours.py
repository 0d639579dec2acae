"""What our engine does with a system, as jobs to be timed, and what each costs in filters."""

from __future__ import annotations

import numpy as np

from benchmarks.measure import Job, Row, Times, ratio
from estimator.batch import batch
from estimator.batch.system import System

TITLES = {
    "log-likelihood": "log-likelihood",
    "smoother, covariances": "filter and smoother with all covariances",
    "smoother, variances": "filter and smoother with variances only",
    "gradient": "value and gradient",
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
    }


def own_rows(times: dict[str, Times], steps: int) -> list[Row]:
    """Cost per step, and in log-likelihoods."""
    one = times["log-likelihood"]
    return [
        *(Row(f"{title}, ours, per step", times[key].per(steps)) for key, title in TITLES.items()),
        ratio("filter and smoother with all covariances / log-likelihood", times["smoother, covariances"], one),
        ratio("filter and smoother with variances only / log-likelihood", times["smoother, variances"], one),
        ratio("value and gradient / log-likelihood", times["gradient"], one, 4.0),
    ]
