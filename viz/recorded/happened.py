"""What happened in a run, in words: drives and stops, channels left out, notes of the recording."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from estimator.faults.fault import Fault
from viz.drawing.scale import Flags
from viz.drawing.series import Event
from viz.recorded.run import ReviewedRun


def events_of(run: ReviewedRun) -> list[Event]:
    """All events of a run in order of time."""
    return sorted([*_notes(run), *_motion(run), *_channels(run)], key=lambda event: event.time_s)


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
            at = f"{run.track.elongation_um[k]:.1f} ± {2 * run.track.sigma_um[k]:.1f} µm"
            yield Event(
                float(time_s[k]), f"drive stops after {time_s[k] - begun:.0f} s at an elongation of {at} (2 sd)"
            )


def _channels(run: ReviewedRun) -> Iterator[Event]:
    """Begins of the stretches in which channels are not fused, though they were read or should have been."""
    together: dict[tuple[float, str], list[str]] = {}
    for i, name in enumerate(run.track.names):
        for begin, sentence in _stretches(run, i, name in run.rig.thermometers):
            together.setdefault((begin, sentence), []).append(name)
    for (begin, sentence), names in together.items():
        yield Event(begin, f"{', '.join(names)} {sentence}", "WARN")


def _stretches(run: ReviewedRun, i: int, steady: bool) -> Iterator[tuple[float, str]]:
    """Time and sentence of each stretch of one channel; one that is not `steady` may be silent between its readings."""
    track, known = run.track, np.isfinite(run.track.measured[:, i])
    if steady:
        for first, count in _blocks(~known):
            yield float(track.time_s[first]), f"not measured for {count} ticks"
    read = np.flatnonzero(known)
    for first, count in _blocks(~track.fused[read, i]):
        worst = Fault(track.fault[read[first : first + count], i].max())
        said = f"{worst.said}: " if worst.said else ""
        yield float(track.time_s[read[first]]), f"{said}not fused for {count} readings"


def _blocks(flags: Flags) -> Iterator[tuple[int, int]]:
    """First index and length of each run of true flags."""
    edges = np.flatnonzero(np.diff(flags.astype(int), prepend=0, append=0))
    for first, end in zip(edges[::2], edges[1::2], strict=True):
        yield int(first), int(end - first)
