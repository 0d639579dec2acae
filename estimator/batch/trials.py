"""Recordings made ready together, for jobs that are done on every one of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from estimator.batch.coarse import coarse, serves
from estimator.batch.trial import Trial
from estimator.model import Model
from estimator.record import Recording
from estimator.rig import Rig
from estimator.work import Runs, Workers


@dataclass(frozen=True)
class Trials:
    """Trials of some recordings, and the workers that share them."""

    trials: Sequence[Trial]
    workers: Workers = map

    def __iter__(self) -> Iterator[Trial]:
        return iter(self.trials)

    def __len__(self) -> int:
        return len(self.trials)

    def __getitem__(self, at: int) -> Trial:
        return self.trials[at]

    def each(self, job: Callable[[Trial], Any]) -> list[Any]:
        """What a job makes of every trial."""
        return list(self.workers(job, self.trials))


def trials_of(model: Model, runs: Runs) -> Trials:
    """Recordings made ready for the filter, tick by tick."""
    return Trials([Trial(model, runs.rig, recording) for recording in runs.recordings], runs.workers)


def slow_trials_of(model: Model, runs: Runs) -> Trials:
    """Recordings made ready for open-loop runs."""
    return Trials([slow_trial(model, runs.rig, recording) for recording in runs.recordings], runs.workers)


def slow_trial(model: Model, rig: Rig, recording: Recording, gated: bool = True) -> Trial:
    """One recording made ready for open-loop runs, at a tick that serves for slow heat."""
    short, slow = coarse(recording, rig, serves(rig))
    return Trial(model, slow, short, gated=gated)
