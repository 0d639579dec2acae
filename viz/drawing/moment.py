"""The moment at which a saved file is worth opening. A layout cannot set the cursor, so the file only remembers it."""

from __future__ import annotations

from pathlib import Path

import rerun as rr
from rerun.chunk import RrdReader

from viz.drawing import paths


def send(rec: rr.RecordingStream, time_s: float) -> None:
    """Remember a moment, s."""
    rec.log(paths.MOMENT, rr.AnyValues(time_s=time_s), static=True)


def moment_of(path: Path) -> float | None:
    """The moment that a saved file remembers, s; None if it is not one of ours."""
    for chunk in RrdReader(path).stream().filter(content=f"/{paths.MOMENT}").to_chunks():
        batch = chunk.to_record_batch()
        if "time_s" in batch.schema.names:
            return float(batch.column("time_s")[0].as_py()[0])
    return None
