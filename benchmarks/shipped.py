"""The engine on the shipped model and a recording of the rig, beside the filter that runs tick by tick on filterpy."""

from benchmarks import paper_rig
from benchmarks.measure import Job, Row, Times, interleaved, ratio, table
from estimator.batch import batch
from estimator.batch.system import System
from estimator.batch.trial import Trial
from estimator.batch.trials import Trials
from estimator.filter import Filter
from estimator.fit.noise import noise_levels
from estimator.record import Recording
from estimator.sensitivity.score import score

RUN = "FS-5"
ROUNDS = 7
TITLES = {
    "log-likelihood": "log-likelihood",
    "smoother, covariances": "filter and smoother with all covariances",
    "smoother, variances": "filter and smoother with variances only",
    "gradient": "value and gradient",
}


def stepped(filter_: Filter, recording: Recording) -> None:
    """All ticks, one after the other, as live takes them."""
    for sample in recording:
        filter_.step(sample)


def own_jobs(system: System) -> dict[str, Job]:
    """The engine's functions on one system."""
    return {
        "log-likelihood": lambda: batch.loglike(system),
        "smoother, covariances": lambda: batch.smoothed(system, covariances=True),
        "smoother, variances": lambda: batch.smoothed(system),
        "gradient": lambda: batch.score(system),
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


def markdown() -> str:
    """Cost per tick and in log-likelihoods; new: with parameters that were not there before."""
    recording, model = paper_rig.recording(RUN), paper_rig.model()
    trial = Trial(model, paper_rig.rig(), recording)
    system, noise = trial.pose(model).system, noise_levels(model, Trials([trial]))
    levels = [path for paths in noise.values() for path in paths]
    jobs = own_jobs(system) | {
        "posed": lambda: trial.loglike(model),
        "passes": lambda: list(batch.passes(system)),
        "filter": lambda: stepped(Filter(model, trial.rig), recording),
        "levels": lambda: score(trial, model, levels),
    }
    times, ticks = interleaved(jobs, ROUNDS), len(system.y)
    rows = [
        *own_rows(times, ticks),
        *_beside_filter(times, ticks),
        ratio("new parameters each time / log-likelihood", times["posed"], times["log-likelihood"]),
        ratio(f"with slopes by {len(levels)} noise levels / new parameters each time", times["levels"], times["posed"]),
    ]
    title = f"Engine: the shipped model, {RUN}, {len(system.x0)} states, {len(system.F)} regimes, {ticks} ticks"
    return table(title, rows, [f"Medians of {ROUNDS} interleaved rounds, ratios of the same round, one thread."])


def _beside_filter(times: dict[str, Times], ticks: int) -> list[Row]:
    one, passes, slow = times["log-likelihood"], times["passes"], times["filter"]
    return [
        Row("filter with all states, ours, per tick", passes.per(ticks)),
        Row("filter on filterpy (estimator.filter), per tick", slow.per(ticks)),
        ratio("log-likelihood, ours / filter on filterpy", one, slow),
        ratio("filter with all states, ours / filter on filterpy", passes, slow),
    ]
