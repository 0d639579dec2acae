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
from estimator.state.run import begin, first_start
from estimator.step import Track

ROWS = 2048  # ticks whose profiles are worked out at a time


def replay(
    model: Model, rig: Rig, recording: Recording, mute: Mute | None = None, each: Callable[[int], None] = lambda _: None
) -> Track:
    """All ticks of a recording. `each` hears how many ticks are done."""
    mute = mute or unmuted(rig)
    begun = first_start(recording, rig, mute)
    if begun is None:
        return Track.waiting(rig.names, recording)
    at, start = begun
    waiting = Track.waiting(rig.names, recording.rows(slice(at)))
    first = recording.rows(slice(at, at + 1))
    if at + 1 == len(recording):
        run = begin(model, rig, recording.sample(at), start, mute(recording.time_s[at]))
        return Track.joined([waiting, Reporter(run).first(first)])
    trial = Trial(model, rig, recording, mute, gated=False)
    posed, reporter = trial.pose(model), Reporter(trial.run)
    parts = [waiting, reporter.first(first)]
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
