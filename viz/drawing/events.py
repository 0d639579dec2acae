"""What happened in a run, in words: drives and stops, channels left out, notes of the recording."""

from __future__ import annotations

from dataclasses import dataclass

import rerun as rr

from viz.drawing import paths


@dataclass(frozen=True)
class Event:
    """One sentence at a time; level is INFO or WARN."""

    time_s: float
    text: str
    level: str = "INFO"


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
