"""The filter over a whole recording by the compiled engine: the same numbers as `Filter`, a tick at a time.

And, after the fact, the smoother: the best estimate of each tick, from the readings before and after it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from estimator.batch import batch
from estimator.batch.system import Chunk
from estimator.batch.trial import Posed, Trial
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.state.gate import Mute, unmuted
from estimator.state.report import Estimates, Reporter
from estimator.state.run import begin
from estimator.step import Track

ROWS = 2048  # ticks whose profiles are worked out at a time


@dataclass(frozen=True)
class SmoothedElongation:
    """Elongation from all readings of a recording, (K,) um, and its standard deviation; NaN before the start."""

    elongation_um: Array
    sigma_um: Array


def replay(
    model: Model, rig: Rig, recording: Recording, mute: Mute | None = None, each: Callable[[int], None] = lambda _: None
) -> Track:
    """All ticks of a recording. `each` hears how many ticks are done."""
    return Replay(model, rig, recording, mute, each).track


class Replay:
    """A recording as the filter leaves it, the `track`, and what the smoother makes of it."""

    def __init__(
        self, model: Model, rig: Rig, recording: Recording, mute: Mute | None, each: Callable[[int], None]
    ) -> None:
        mute = mute or unmuted(rig)
        run = begin(model, rig, recording, mute)
        at = len(recording) if run is None else run.tick
        parts = [Track.waiting(rig.names, recording.rows(slice(at)))]
        self._posed: Posed | None = None
        if run is not None:
            reporter = Reporter(run)
            parts.append(reporter.first(recording.rows(slice(at, at + 1))))
        if run is not None and at + 1 < len(recording):
            trial = Trial(model, rig, recording, mute, gated=False)
            self._posed = trial.pose(model)
            for chunk in trial.filtered(self._posed):
                parts += [reporter.track(trial.rest.rows(rows), it) for rows, it in _estimates(self._posed, chunk)]
                each(at + 1 + chunk.ticks.stop)
        self.track = Track.joined(parts)

    def smoothed(self) -> SmoothedElongation:
        """The elongation after the fact, from the readings that the filter fused; nothing for less than two ticks."""
        um, sigma = np.full((2, len(self.track)), np.nan)
        if self._posed is not None:
            T = len(self._posed.system.y)
            system = replace(self._posed.system, muted=~self.track.fused[-T:])
            elongation = len(system.H)  # the channel that is never read
            found = batch.smoothed(replace(self._posed, system=system).with_elongation(), channels=[elongation])
            grows = np.isfinite(self.track.elongation_um[-T:])
            um[-T:] = np.where(grows, found.reading[:, 0], np.nan)
            sigma[-T:] = np.where(grows, np.sqrt(np.maximum(found.reading_var[:, 0], 0.0)), np.nan)
            um[-T - 1], sigma[-T - 1] = self.track.elongation_um[-T - 1], self.track.sigma_um[-T - 1]
        return SmoothedElongation(um, sigma)


def _estimates(posed: Posed, chunk: Chunk) -> Iterator[tuple[slice, Estimates]]:
    """A chunk's ticks, some at a time."""
    run, offset = posed.run, posed.offset[1:]
    for k in range(0, len(chunk.x), ROWS):
        some = slice(k, k + ROWS)
        at = slice(chunk.ticks.start + k, min(chunk.ticks.start + k + ROWS, chunk.ticks.stop))
        estimates = Estimates(
            x=chunk.x[some],
            P=chunk.P[some],
            predicted=chunk.predicted[some] + offset[at] + run.lag[at] + run.late[at],
            sd=chunk.sd[some],
            fused=chunk.fused[some],
            nis=chunk.nis[some],
            alone=run.lagged[at] + offset[at],
            grown_um=run.grown[at],
        )
        yield at, estimates
