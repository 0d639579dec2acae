"""Recordings and their truth: files in, records out."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from drivers.budget import Budget
from drivers.decode.addresses import addressed
from drivers.decode.buses import chosen, in_order, of_the_rig, on_one_clock, together, told_once
from drivers.decode.clock import RigClock, date_of
from drivers.decode.decode import Decoder
from drivers.decode.ticks import Ticks, at_the_pace, split, told_step
from drivers.frames import Array, Frames, Tally
from drivers.lab.estimates import is_estimates
from drivers.lab.lab import read_lab
from drivers.lab.signals import is_decoded, read_signals
from drivers.logs.joined import Progress, join
from drivers.logs.logs import SUFFIXES, is_lab_csv, read_log
from drivers.logs.truth import is_truth
from drivers.silences import silences
from estimator.errors import InputError
from estimator.record import Recording
from estimator.rig import Rig


def find_recordings(paths: Iterable[Path]) -> list[Path]:
    """The recordings among these files and folders, in order; a folder means all logs in it, sorted by name.

    Truth files are left out, and of a folder the tables that `review` has written into it; any other file is kept,
    reading it says what is wrong with it. A folder without a log is an InputError.
    """
    recordings: list[Path] = []
    for path in map(Path, paths):
        inside = [path]
        if path.is_dir():
            inside = sorted(p for p in path.iterdir() if p.is_file() and p.suffix.lower() in SUFFIXES)
            inside = [p for p in inside if not is_truth(p) and not is_estimates(p)]
            if not inside:
                raise InputError(f"{path}: no recording in this folder; expected files *{', *'.join(sorted(SUFFIXES))}")
        recordings += [p for p in inside if p not in recordings and not is_truth(p)]
    return recordings


def read_recording(
    path: Path | str, rig: Rig, progress: Progress | None = None, budget: Budget | None = None
) -> Recording:
    """Read a log of CAN frames, a lab CSV or the signals of an MF4 into ticks.

    A torn or odd log is read as far as it goes and `notes` and `skipped` say what was not used. One of which nothing
    can be used is an InputError; a rig file that does not fit its DBC is a SetupError. `progress` is told the share
    that is read, 0 ... 1.
    """
    path = Path(path)
    tally = Tally()
    budget = budget or Budget()
    if is_truth(path):
        raise InputError(f"{path}: the truth of a simulated recording, not a recording")
    if is_estimates(path):
        raise InputError(f"{path}: what `review --table` has written of a recording, not a recording")
    if is_lab_csv(path):
        rows = read_lab(path, rig, tally, budget)
    elif is_decoded(path):
        rows = read_signals(path, rig, tally, budget)
    else:
        return recording_of(path, read_log(path, tally, budget, progress), rig, tally, budget)
    return _told(rows, path.name, rig, tally)


def recording_of(path: Path, frames: Frames, rig: Rig, tally: Tally, budget: Budget) -> Recording:
    """The frames of a log as ticks; `tally` has what its reader skipped."""
    return _told(_ticks(str(path), frames, frames.where, rig, tally, budget), path.name, rig, tally)


def _told(rows: Recording, name: str, rig: Rig, tally: Tally) -> Recording:
    silences(rows, rig, tally)
    doubts = tuple(note for note in tally.notes if note in tally.doubts)
    return replace(rows, name=name, skipped=tally.counts(), notes=tuple(tally.notes), doubts=doubts)


def read_joined(
    paths: Sequence[Path], rig: Rig, progress: Progress | None = None, budget: Budget | None = None
) -> tuple[Path, Recording]:
    """Read logs of CAN frames that are parts of one recording: the path of the first of them, and all as one.

    They follow each other in the order of their first frames; time and readings go on from one to the next. One of
    which nothing can be used is told in `notes`. Everything else is as in `read_recording`.
    """
    tally = Tally()
    budget = budget or Budget()
    joined = join(paths, tally, budget, progress)
    first = joined.paths[0]
    rows = _ticks(f"{first}..", joined.frames, joined.where, rig, tally, budget)
    return first, _told(rows, f"{first.name}..", rig, tally)


def _ticks(name: str, frames: Frames, where: Callable[[int], str], rig: Rig, tally: Tally, budget: Budget) -> Recording:
    decoder = Decoder(rig, tally)
    frames, now = _on_the_rigs_clock(name, frames, where, decoder, budget)
    ticks = Ticks(rig.tick_s, rig.log.closes is not None)
    what, closes = f"{name}: {len(frames)} frames", decoder.closings(frames)[0]
    row, date = split(what, now, closes, ticks, budget.ticks, tally)
    told_step(date, rig.tick_s, tally)
    rows = decoder.whole(frames.take(slice(len(row))), now[: len(row)], row, date)
    return replace(rows, frames=len(frames), began_s=date_of(frames.time, now))


def _on_the_rigs_clock(
    name: str, frames: Frames, where: Callable[[int], str], decoder: Decoder, budget: Budget
) -> tuple[Frames, Array]:
    """The rig's frames in order, and the rig's clock at each, (n,) s; what else that takes is let go with it."""
    rig, tally = decoder.rig, decoder.tally
    rigs = told_once(frames, rig.tick_s, tally)
    rigs = rigs[chosen(frames.take(rigs), rig.log.bus, name)]
    frames = addressed(frames.take(rigs), decoder.used, decoder.dbc, name, tally)
    if why := decoder.mismatch(frames):
        raise InputError(f"{name}: {len(frames)} frames, none of this rig: {why}")
    for pick in (decoder.not_ours, partial(of_the_rig, wanted=decoder.wanted, name=name, tally=tally)):
        kept = pick(frames)
        frames, rigs = frames.take(kept), rigs[kept]
    frames = frames.on_clock(on_one_clock(frames, name, tally))
    kept = in_order(frames, rig.tick_s, name, tally)
    frames, rigs = frames.take(kept), rigs[kept]
    together(frames, tally)
    decoder.never_came(frames)
    clock = RigClock(rig.tick_s, decoder.scan.modulus, tally, lambda frame: where(int(rigs[frame])), budget)
    closes, scan = decoder.closings(frames)
    at_the_pace(name, frames.time[closes], rig.tick_s)
    now = clock.run(frames.time, closes, scan)
    known = np.isfinite(now)
    return (frames, now) if known.all() else (frames.take(known), now[known])
