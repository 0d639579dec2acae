"""The engine on the shipped model and a recording of the rig, beside the filter that runs tick by tick on filterpy."""

from __future__ import annotations

import numpy as np

from benchmarks import paper_rig
from benchmarks.measure import Row, Times, interleaved, ratio, table
from benchmarks.ours import own_jobs, own_rows
from benchmarks.peers import gaussian
from estimator.batch import batch
from estimator.batch.trial import Trial
from estimator.filter import Filter, Fusion
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.sensitivity.score import score

RUN = "FS-5"
ROUNDS = 7
FREE = (5, 10, 20)


class _Likelihood(Fusion):
    """The online filter's estimate, with the log-likelihood of what it fuses, from its innovations."""

    loglike = 0.0

    def update(self, reading: Array, fuse: Array, H: Array, R: Array) -> tuple[float, Array]:
        nis, gain = super().update(reading, fuse, H, R)
        if np.isfinite(nis):
            self.loglike += gaussian(self._filterpy.y, self._filterpy.S)
        return nis, gain


def loglike_by_hand(model: Model, rig: Rig, recording: Recording) -> float:
    """Log-likelihood of a recording after its first sample, by the filter that runs tick by tick."""
    filter_, (first, *rest) = Filter(model, rig), recording
    filter_.step(first)
    filter_.fusion = told = _Likelihood(filter_.fusion.x, filter_.fusion.P)
    for sample in rest:
        filter_.step(sample)
    return told.loglike


def stepped(filter_: Filter, recording: Recording) -> None:
    """All ticks, one after the other, as live takes them."""
    for sample in recording:
        filter_.step(sample)


def trial_of(name: str) -> tuple[Trial, Recording]:
    """A recording of the shipped rig, posed for the shipped model."""
    recording = paper_rig.recording(name)
    return Trial(paper_rig.model(), paper_rig.rig(), recording), recording


def markdown() -> str:
    """Cost per tick and in log-likelihoods; what a gradient costs with the number of parameters."""
    trial, recording = trial_of(RUN)
    model = paper_rig.model()
    system, free = trial.pose(model).system, model.free()
    jobs = own_jobs(system) | {
        "posed": lambda: trial.loglike(model),
        "passes": lambda: list(batch.passes(system)),
        "filter": lambda: stepped(Filter(model, trial.rig), recording),
        **{f"free {p}": lambda p=p: score(trial, model, free[:p]) for p in FREE},
    }
    times, ticks, by_hand = interleaved(jobs, ROUNDS), len(system.y), loglike_by_hand(model, trial.rig, recording)
    apart = abs(by_hand - batch.loglike(system)) / abs(by_hand)
    rows = [
        Row("log-likelihood, relative difference from the filterpy filter's", f"{apart:.1e}", apart, 1e-9),
        *own_rows(times, ticks),
        *_beside_filter(times, ticks),
        *_by_parameters(times),
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


def _by_parameters(times: dict[str, Times]) -> list[Row]:
    """Growth with the number of parameters: `posed` is a log-likelihood by parameters that were not there before."""
    few, many = FREE[0], FREE[-1]
    return [
        ratio("new parameters each time / log-likelihood", times["posed"], times["log-likelihood"]),
        *(ratio(f"with gradient by {p} / new parameters each time", times[f"free {p}"], times["posed"]) for p in FREE),
        ratio(f"gradient by {many} parameters / by {few}", times[f"free {many}"], times[f"free {few}"]),
    ]
