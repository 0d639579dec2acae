"""Recordings made ready together, for jobs that are done on every one of them."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from estimator.batch.coarse import coarse, serves
from estimator.batch.trial import Trial
from estimator.faults.use import Use
from estimator.model import Model
from estimator.record import Recording
from estimator.rig import Rig
from estimator.work import Runs, Workers, kept


@dataclass(frozen=True)
class Trials:
    """Trials of some recordings, the workers that share them, and what is used of each."""

    trials: Sequence[Trial]
    workers: Workers = map
    uses: tuple[Use, ...] = ()

    def __iter__(self) -> Iterator[Trial]:
        return iter(self.trials)

    def __len__(self) -> int:
        return len(self.trials)

    def __getitem__(self, at: int) -> Trial:
        return self.trials[at]

    def each(self, job: Callable[[Trial], Any]) -> list[Any]:
        """What a job makes of every trial."""
        return list(kept(self.workers)(job, self.trials))


def trials_of(model: Model, runs: Runs) -> Trials:
    """Recordings made ready for the filter, tick by tick."""
    return _ready(model, runs, lambda trial: trial)


def slow_trials_of(model: Model, runs: Runs, believed: Sequence[str] = ()) -> Trials:
    """Recordings made ready for open-loop runs; `believed`: channels that are heard whatever the judge says of them."""
    return _ready(model, runs, lambda trial: slowed(trial, model), believed)


def _ready(model: Model, runs: Runs, made_of: Callable[[Trial], Trial], believed: Sequence[str] = ()) -> Trials:
    rig = runs.rig

    def ready(recording: Recording) -> tuple[Trial, Use]:
        trial = Trial(model, rig, recording, believed=believed)
        return made_of(trial), trial.use

    found = runs.each(ready)
    return Trials([trial for trial, _ in found], runs.workers, tuple(use for _, use in found))


def slow_trial(model: Model, rig: Rig, recording: Recording) -> Trial:
    """One recording made ready for open-loop runs, after the filter's judge has heard it tick by tick."""
    return slowed(Trial(model, rig, recording), model)


def beside(other: Trial, trial: Trial) -> Trial:
    """The trial, its misfits as long alike as those of another, with which they are compared."""
    trial.block_s = other.block_s
    return trial


def slowed(trial: Trial, model: Model) -> Trial:
    """A trial's recording, without what was refused, at a tick that serves for slow heat."""
    return unjudged(model, trial.rig, trial.heard)


def unjudged(model: Model, rig: Rig, recording: Recording) -> Trial:
    """The same of a recording as it is."""
    short, slow = coarse(recording, rig, serves(rig))
    return Trial(model, slow, short, gated=False)
