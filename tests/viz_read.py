"""Reading a saved file back with the reader of its format."""

from functools import lru_cache
from pathlib import Path

import numpy as np
import pyarrow as pa
from rerun.chunk import RrdReader

from estimator.record import Array

Logged = dict[str, list[tuple[bool, pa.RecordBatch]]]


def rows(path: Path, entity: str, component: str) -> tuple[Array, list[list]]:
    """Times (n,) s and rows of one component of one entity, in order of time."""
    times, values = [], []
    for _, batch in logged(path).get(entity, []):
        if component in batch.schema.names and "time" in batch.schema.names:
            times.append(batch.column("time").cast("int64").to_numpy() / 1e9)
            values += batch.column(component).to_pylist()
    at = np.concatenate(times)
    return np.sort(at), [values[i] for i in np.argsort(at, kind="stable")]


def state_at(path: Path, lane: str, *when_s: float) -> list[str]:
    """What a lane says at times, "" before it says anything."""
    time_s, states = rows(path, lane, "StateChange:state")
    last = np.searchsorted(time_s, when_s, side="right") - 1
    return [states[k][0] if k >= 0 else "" for k in last]


def fixed(path: Path, entity: str, component: str) -> list:
    """What was logged for an entity for all times, the last time."""
    found = None
    for always, batch in logged(path).get(entity, []):
        if always and component in batch.schema.names:
            found = batch.column(component)[-1].as_py()
    assert found is not None, f"{entity} has no {component}"
    return found


def pixels(path: Path, entity: str) -> Array:
    """A picture (height, width, 3) as it was logged."""
    form = fixed(path, entity, "Image:format")[0]
    bytes_of = np.array(fixed(path, entity, "Image:buffer")[0], dtype=np.uint8)
    return bytes_of.reshape(form["height"], form["width"], 3)


def view_names(path: Path) -> list[str]:
    """Names of the views in the layout that the file carries."""
    reader = RrdReader(path)
    batches = [chunk.to_record_batch() for chunk in reader.stream(store=reader.blueprints()[0]).to_chunks()]
    key = "ViewBlueprint:display_name"
    return [batch.column(key)[0].as_py()[0] for batch in batches if key in batch.schema.names]


def has_no_empty_chunk(path: Path) -> bool:
    """The viewer panics at a chunk without rows."""
    return all(batch.num_rows for each in logged(path).values() for _, batch in each)


def logged(path: Path) -> Logged:
    """What was logged for each entity: whether for all times, and what. A test asks for many of one file."""
    return _logged(path, path.stat().st_mtime_ns)


@lru_cache(maxsize=8)
def _logged(path: Path, written_ns: int) -> Logged:
    found: Logged = {}
    for chunk in RrdReader(path).stream().to_chunks():
        found.setdefault(chunk.entity_path, []).append((chunk.is_static, chunk.to_record_batch()))
    return found
