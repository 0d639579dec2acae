"""The recording that a folder ends with: whoever starts again there may go on with it."""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from drivers.budget import Budget
from drivers.frames import Tally
from drivers.logs.every_frame import one_by_one
from drivers.logs.joined import join
from drivers.received import Received
from estimator.errors import InputError

AHEAD_S = 60.0  # that a clock may have been set back since
_STAMP = re.compile(rb"^\((\d{1,10}\.\d{1,9})\) [^\n]*\n", re.MULTILINE)
_ENDS = 4096  # bytes at both ends of a file, in which there is a whole line


class Written(NamedTuple):
    """A part of a recording, and the stamps of its first and last frame."""

    path: Path
    first_s: float
    last_s: float


def earlier(folder: Path, about: Mapping[str, Any], now_s: float) -> list[Path]:
    """The parts of the recording that ended less than an hour before `now_s`, in order; none where there is none.

    A part belongs to it when it was recorded of the same rig on the same bus (`about`), at most an hour after the part
    before. What was killed while it wrote counts as what was closed.
    """
    parts = sorted(_written(folder, about), key=lambda part: part.first_s)
    gap_s, kept, until_s = Budget().gap_s, list[Path](), now_s
    for part in reversed(parts):
        if not -AHEAD_S < until_s - part.last_s < gap_s:
            break
        kept.insert(0, part.path)
        until_s = part.first_s
    return kept


def frames_of(parts: list[Path]) -> Iterator[Received]:
    """The frames of these parts, as they came; nothing where none can be read."""
    try:
        yield from one_by_one(join(parts, Tally(), Budget()).frames)
    except InputError:
        return


def _written(folder: Path, about: Mapping[str, Any]) -> Iterator[Written]:
    """Every part in the folder that is of this rig and bus."""
    for path in folder.glob("*.log"):
        try:
            said = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))["about"]
            stamps = _stamps(path)
        except (OSError, ValueError, KeyError, TypeError):
            continue
        if stamps and all(said.get(key) == about[key] for key in ("rig", "bus", "speed_up")):
            yield Written(path, *stamps)


def _stamps(path: Path) -> tuple[float, float] | None:
    """Stamps of the first and the last whole line; None where there is none."""
    with path.open("rb") as file:
        head = file.read(_ENDS)
        file.seek(max(0, path.stat().st_size - _ENDS))
        tail = file.read()
    found = _STAMP.findall(head)[:1] + _STAMP.findall(tail)[-1:]
    return (float(found[0]), float(found[1])) if len(found) == 2 else None
