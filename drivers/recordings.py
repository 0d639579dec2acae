"""Recordings and their truth: files in, records out."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from drivers.budget import Budget
from drivers.clock import RigClock
from drivers.decode import Decoder
from drivers.frames import Frames, Tally
from drivers.logs import SUFFIXES, read_log
from drivers.ticks import Ticks, split
from estimator.errors import InputError
from estimator.record import Recording
from estimator.rig import Rig

Progress = Callable[[float], None]


def find_recordings(paths: Iterable[Path]) -> list[Path]:
    """The recordings among these files and folders, in order; a folder means all logs in it, sorted by name.

    A path that is neither is kept: reading it says what is wrong with it. A truth file is never a recording.
    """
    found: list[Path] = []
    for path in paths:
        inside = sorted(p for p in path.iterdir() if _is_log(p)) if path.is_dir() else [path]
        found += [p for p in inside if p not in found]
    return found


def _is_log(path: Path) -> bool:
    return path.is_file() and path.suffix.lower() in SUFFIXES and not path.name.lower().endswith(".truth.csv")


def read_recording(path: Path, rig: Rig, progress: Progress | None = None, budget: Budget | None = None) -> Recording:
    """Read a log of CAN frames or a lab CSV into ticks.

    A torn or odd log is read as far as it goes and `notes` and `skipped` say what was not used. One of which nothing
    can be used is an InputError; a rig file that does not fit its DBC is a SetupError. `progress` is told the share
    that is read, 0 ... 1.
    """
    path = Path(path)
    tally = Tally()
    budget = budget or Budget()
    decoder = Decoder(rig, tally)
    frames = read_log(path, tally, budget, progress)
    return replace(_ticks(frames, decoder, budget, path), name=path.name)


def _ticks(frames: Frames, decoder: Decoder, budget: Budget, path: Path) -> Recording:
    rig, tally = decoder.rig, decoder.tally
    clock = RigClock(rig.tick_s, tally, frames.where, budget)
    closes, scan = decoder.closings(frames)
    now = clock.run(frames.time, closes, scan)
    kept = np.isfinite(now)
    if not kept.all():
        frames, now, closes = frames.take(kept), now[kept], closes[kept]
    ends, date = split(now, closes, Ticks(rig.tick_s, rig.log.closes is not None), budget.ticks, tally)
    if not len(ends):
        raise InputError(f"{path}: {len(frames)} frames over {now[-1]:.3g} s, less than one tick of {rig.tick_s:g} s")
    tally.skip("after the last whole tick", len(frames) - ends[-1])
    inside = slice(0, int(ends[-1]))
    row = np.repeat(np.arange(len(ends)), np.diff(ends, prepend=0))
    rows = decoder.rows(frames.take(inside), 0, now[inside], row, date)
    return replace(rows, frames=len(frames), skipped=dict(tally.skipped), notes=tuple(tally.notes))
