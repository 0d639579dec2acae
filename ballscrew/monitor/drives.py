"""Drives and stops as they come, in words: told once they have lasted, from when they began."""

from dataclasses import dataclass

import numpy as np

from estimator.inputs.phase import stopped, turns
from estimator.record import Sample
from estimator.step import Step

LASTS_S = 10.0  # a table that rests between strokes has not stopped


@dataclass(frozen=True)
class Turn:
    """A drive or a rest that has begun; `text` says so."""

    driving: bool
    since_s: float
    text: str = ""


class Drives:
    """What the table does.

    now  None while that is not known
    """

    def __init__(self) -> None:
        self.now: Turn | None = None
        self._next: Turn | None = None

    def tick(self, sample: Sample, step: Step) -> Turn | None:
        """What has begun, once it has lasted."""
        if np.isnan(sample.omega):
            return None
        driving = bool(turns(sample.omega))
        if self.now is None or step.time_s < self.now.since_s:  # the first tick, of another run maybe
            self.now, self._next = Turn(driving, step.time_s), None
        if driving == self.now.driving:
            self._next = None
        elif self._next is None:
            self._next = Turn(driving, step.time_s, self._text(driving, step))
        elif step.time_s - self._next.since_s >= LASTS_S:
            self.now, self._next = self._next, None
            return self.now
        return None

    def _text(self, driving: bool, step: Step) -> str:
        assert self.now is not None
        begun_s = self.now.since_s if self.now.text else np.nan
        if driving:
            return "drive starts"
        return stopped(step.time_s - begun_s, step.elongation_um, step.sigma_um, step.open_loop_um)
