"""What happened in a run, in words: drives and stops, channels left out, notes of the recording."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import rerun as rr

from viz import paths
from viz.run import Run


@dataclass(frozen=True)
class Event:
    """One sentence at a time; level is INFO or WARN."""

    time_s: float
    text: str
    level: str = "INFO"


def events_of(run: Run) -> list[Event]:
    """All events of a run in order of time."""
    return sorted([*_notes(run), *_motion(run), *_channels(run)], key=lambda event: event.time_s)


def _notes(run: Run) -> Iterator[Event]:
    first = float(run.track.time_s[0])
    yield Event(first, f"{run.name}: {len(run.recording)} ticks from {run.recording.frames} frames")
    for note in run.recording.notes:
        yield Event(first, note, "WARN")
    for reason, count in run.recording.skipped.items():
        yield Event(first, f"not used: {count} x {reason}", "WARN")


def _motion(run: Run) -> Iterator[Event]:
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


def _channels(run: Run) -> Iterator[Event]:
    """Begin of each stretch in which a channel is not fused, though it was read or should have been."""
    track = run.track
    for i, name in enumerate(track.names):
        silent = ~np.isfinite(track.measured[:, i])
        expected = name in run.rig.thermometers
        for why, out in (("not measured", silent & expected), ("not fused", ~silent & ~track.fused[:, i])):
            edges = np.flatnonzero(np.diff(out.astype(int), prepend=0, append=0))
            for begin, end in zip(edges[::2], edges[1::2], strict=True):
                yield Event(float(track.time_s[begin]), f"{name} {why} for {end - begin} ticks", "WARN")


def clock(time_s: float) -> str:
    """Time since the start as h:mm:ss."""
    minutes, seconds = divmod(round(time_s), 60)
    return f"{minutes // 60}:{minutes % 60:02d}:{seconds:02d}"


def send(rec: rr.RecordingStream, root: str, events: list[Event]) -> None:
    """Log events."""
    index = [rr.TimeColumn(paths.TIMELINE, duration=[event.time_s for event in events])]
    texts = [f"{clock(event.time_s)}  {event.text}" for event in events]
    columns = rr.TextLog.columns(text=texts, level=[event.level for event in events])
    rec.send_columns(f"{root}/{paths.EVENTS}", indexes=index, columns=columns)
