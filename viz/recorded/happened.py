"""What happened in a run, in words: drives and stops, alarms, notes of the recording."""

from collections.abc import Iterator

import numpy as np

from estimator.inputs.phase import stopped
from viz.drawing.scale import clock
from viz.drawing.series import Event
from viz.lanes.standing import Judged
from viz.recorded.run import ReviewedRun


def events_of(run: ReviewedRun) -> list[Event]:
    """All events of a run in order of time."""
    return sorted([*_notes(run), *_motion(run), *_judged(run)], key=lambda event: event.time_s)


def _notes(run: ReviewedRun) -> Iterator[Event]:
    first = float(run.track.time_s[0])
    yield Event(first, f"{run.name}: {len(run.recording)} ticks from {run.recording.frames} frames")
    for note in run.recording.notes:
        yield Event(first, note, "WARN")
    for reason, count in run.recording.skipped.items():
        yield Event(first, f"not used: {count} x {reason}", "WARN")


def _motion(run: ReviewedRun) -> Iterator[Event]:
    time_s, begun = run.track.time_s, float("nan")
    for k in np.flatnonzero(np.diff(run.turning.astype(int), prepend=0)):
        if run.turning[k]:
            begun = float(time_s[k])
            yield Event(begun, "drive starts")
        else:
            grown = run.track.elongation_um[k], run.track.sigma_um[k], run.track.open_loop_um[k]
            said = stopped(float(time_s[k]) - begun, *grown)
            yield Event(float(time_s[k]), said)


def _judged(run: ReviewedRun) -> Iterator[Event]:
    """Alarms that begin and end, and when the estimate is not to be relied on, as `live` says it."""
    before = Judged(0.0, (), ())
    for now in run.judged:
        for alarm in (each for each in now.alarms if each not in before.alarms):
            yield Event(now.time_s, f"alarm: {alarm.text}, since {clock(alarm.since_s)}", "WARN")
        for alarm in (each for each in before.alarms if each not in now.alarms):
            yield Event(now.time_s, f"over: {alarm.text}")
        if now.why != before.why:
            lost = f"estimate valid no longer: {', '.join(now.why)}"
            yield Event(now.time_s, lost, "WARN") if now.why else Event(now.time_s, "estimate valid again")
        before = now
