"""The filter over a whole recording by the compiled engine: the same numbers as `Filter`, a tick at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from estimator.batch.system import Chunk
from estimator.batch.trial import Posed, Trial
from estimator.model import Model
from estimator.record import Recording
from estimator.rig import Rig
from estimator.state.gate import Mute, unmuted
from estimator.state.report import Estimates, Reporter
from estimator.state.run import begin
from estimator.step import Track

ROWS = 2048  # ticks whose profiles are worked out at a time


def replay(
    model: Model, rig: Rig, recording: Recording, mute: Mute | None = None, each: Callable[[int], None] = lambda _: None
) -> Track:
    """All ticks of a recording. `each` hears how many ticks are done."""
    mute = mute or unmuted(rig)
    run = begin(model, rig, recording, mute)
    if run is None:
        return Track.waiting(rig.names, recording)
    at, reporter = run.tick, Reporter(run)
    parts = [Track.waiting(rig.names, recording.rows(slice(at))), reporter.first(recording.rows(slice(at, at + 1)))]
    if at + 1 == len(recording):
        return Track.joined(parts)
    trial = Trial(model, rig, recording, mute, gated=False)
    posed = trial.pose(model)
    for chunk in trial.filtered(posed):
        parts += [reporter.track(trial.rest.rows(rows), it) for rows, it in _estimates(posed, chunk)]
        each(at + 1 + chunk.ticks.stop)
    return Track.joined(parts)


def _estimates(posed: Posed, chunk: Chunk) -> Iterator[tuple[slice, Estimates]]:
    """A chunk's ticks, some at a time."""
    run, offset = posed.run, posed.offset[1:]
    for k in range(0, len(chunk.x), ROWS):
        some = slice(k, k + ROWS)
        at = slice(chunk.ticks.start + k, min(chunk.ticks.start + k + ROWS, chunk.ticks.stop))
        yield (
            at,
            Estimates(
                x=chunk.x[some],
                P=chunk.P[some],
                predicted=chunk.predicted[some] + offset[at] + run.lag[at] + run.late[at],
                sd=chunk.sd[some],
                fused=chunk.fused[some],
                nis=chunk.nis[some],
                alone=run.lagged[at] + offset[at],
                grown_um=run.grown[at],
            ),
        )
