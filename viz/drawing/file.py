"""A saved file: one recording of the viewer's with its layout, its summary, and the moment worth opening it at.

A layout cannot set the cursor, so the file remembers that moment. A file with several recordings would open with the
first one only and no hint at the others, so all runs go into one, each below its own name, side by side on a timeline
that starts with each run's first frame.
"""

import uuid
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import rerun as rr
import rerun.blueprint as rrb
from rerun.chunk import RrdReader

from estimator.errors import InputError
from viz.drawing import paths
from viz.drawing.entity import Entity

Named = TypeVar("Named", bound=Any)  # a dataclass with a name


def stream(identity: uuid.UUID, path: Path | None = None) -> rr.RecordingStream:
    """An empty stream, into `path` if one is given."""
    rec = rr.RecordingStream(paths.APPLICATION, recording_id=identity)
    rec.set_log_time_enabled(False)
    if path is not None:
        if not path.parent.is_dir():
            raise InputError(f"{path}: there is no folder {path.parent}")
        try:
            rec.save(path)
        except RuntimeError as error:
            raise InputError(f"{path}: cannot be written ({error})") from error
    return rec


def begin(rec: rr.RecordingStream, layout: rrb.Blueprint, name: str) -> None:
    """Say how a stream is shown and what it is called."""
    rec.send_blueprint(layout, make_active=True, make_default=True)
    rec.send_recording_name(name)


@contextmanager
def saved(path: Path, layout: rrb.Blueprint, name: str, summary: str, opens_at_s: float) -> Iterator[Entity]:
    """The root of a stream into `path` (.rrd) until the block ends: layout, name and summary are in it already."""
    rec = stream(uuid.uuid4(), path)
    begin(rec, layout, name)
    root = Entity(rec)
    (root / paths.SUMMARY).text(summary)
    (root / paths.MOMENT).log(rr.AnyValues(time_s=opens_at_s))
    yield root
    rec.disconnect()


def opens_at(path: Path) -> float | None:
    """The moment that a saved file remembers, s; None if it is not one of ours."""
    for chunk in RrdReader(path).stream().filter(content=f"/{paths.MOMENT}").to_chunks():
        batch = chunk.to_record_batch()
        if "time_s" in batch.schema.names:
            return float(batch.column("time_s")[0].as_py()[0])
    return None


def distinct(runs: Sequence[Named]) -> list[Named]:
    """The runs with names that lead to different paths: a name met before gets a number."""
    found: dict[str, Named] = {}
    for run in runs:
        name, number = run.name, 1
        while paths.root(name) in found:
            number += 1
            name = f"{run.name} ({number})"
        found[paths.root(name)] = replace(run, name=name)
    return list(found.values())
