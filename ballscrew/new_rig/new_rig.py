"""From recordings of a rig that nobody has described to a rig folder that works: what is in them, guesses, files."""

import filecmp
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ballscrew.new_rig.bus_log import OURS, BusLog, read_bus_log
from ballscrew.new_rig.drive import drive
from ballscrew.new_rig.geometry import Geometry, geometry
from ballscrew.new_rig.growth import growth
from ballscrew.new_rig.lab_table import LabTable, is_lab_table, read_lab_table
from ballscrew.new_rig.model_file import EFFECTS, write_model
from ballscrew.new_rig.rig_file import lines_of, log_of_bus, log_of_csv, rig_text
from ballscrew.new_rig.scan import scan_of
from ballscrew.new_rig.seen import Guess, Seen, behind_each_other, named_apart
from ballscrew.new_rig.temperatures import THERMOMETER, temperatures
from drivers.frames import Array, Tally
from drivers.logs.joined import Progress
from drivers.recordings import read_recording
from estimator.battery.admitted import admit
from estimator.errors import SetupError
from estimator.record import Recording
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig

_FASTEST_S = 0.5  # from reading to reading, of ticks: faster thermometers are read once a second
RIG, MODEL = "rig.toml", "model.toml"


@dataclass(frozen=True)
class Found:
    """What is in recordings and what it is taken as.

    seen  every signal        guesses  those that are taken for something, thermometers first
    """

    paths: tuple[Path, ...]
    sources: tuple[BusLog | LabTable, ...]
    seen: tuple[Seen, ...]
    guesses: tuple[Guess, ...]
    tick_s: float

    @property
    def unused(self) -> list[Seen]:
        """Signals that are taken for nothing."""
        taken = {one.source for guess in self.guesses for one in guess.seen}
        return [one for one in self.seen if one.source not in taken]

    @property
    def never(self) -> tuple[str, ...]:
        """Messages of the DBC that did not come in the first of them."""
        first = self.sources[0]
        return first.never if isinstance(first, BusLog) else ()

    @property
    def dbc(self) -> Path | None:
        """The DBC of logs of CAN frames."""
        first = self.sources[0]
        return first.dbc.path if isinstance(first, BusLog) else None


@dataclass(frozen=True)
class NewRig:
    """A rig folder that was written, and its first recording as it reads there.

    heated  whether a heater is in the recordings
    """

    folder: Path
    parts: Geometry
    recording: Recording
    files: tuple[str, ...]
    heated: bool


def find(paths: Sequence[Path], dbc: Path | None, progress: Progress | None = None) -> Found:
    """Look at recordings, all of a kind; signals of several are one behind the other."""
    kinds = [is_lab_table(path) for path in paths]
    if len({*kinds}) > 1:
        other = paths[kinds.index(not kinds[0])]
        raise SetupError(
            f"{paths[0]} and {other}: logs of CAN frames and tables of a lab are of two rig folders; take one kind"
        )
    if kinds[0] and dbc is not None:
        raise SetupError(f"--dbc {dbc}: {paths[0]} holds no frames, its signals have their names; leave it out")
    sources: list[BusLog | LabTable] = []
    for k, path in enumerate(paths):
        share = progress and partial(lambda k, done: progress((k + done) / len(paths)), k)
        sources.append(read_lab_table(path, Tally()) if kinds[0] else read_bus_log(path, dbc, Tally(), share))
    every = tuple(behind_each_other([source.seen for source in sources]))
    guesses = _guesses(every)
    return Found(tuple(paths), tuple(sources), every, guesses, _tick(guesses))


def _guesses(seen: Sequence[Seen]) -> tuple[Guess, ...]:
    warm = temperatures(seen)
    taken = {one.source for guess in warm for one in guess.seen}
    rest = [one for one in seen if one.source not in taken]
    moving = drive(rest)
    grown = list(growth(rest, moving, _warmth([guess for guess in warm if guess.role == THERMOMETER])))
    return tuple(named_apart((*warm, *moving, *grown)))


def _warmth(thermometers: Sequence[Guess]) -> tuple[Array, Array]:
    """Times, (n,) s, and the mean temperature of the thermometers over that of the first reading of each, (n,) K."""
    time = thermometers[0].time
    rises = [np.interp(time, one.time, one.value) - one.value[0] for one in thermometers]
    return time, np.mean(rises, axis=0)


def _tick(guesses: Sequence[Guess]) -> float:
    step = float(np.median([g.seen[0].step_s for g in guesses if g.role == THERMOMETER]))
    if not np.isfinite(step) or step < _FASTEST_S:
        return 1.0
    return min(float(f"{step:.2g}"), 3600.0)


def write(found: Found, folder: Path, places: Sequence[float] = (), force: bool = False) -> NewRig:
    """Write the rig folder: nothing before all of it works, nothing that is there without `force`."""
    parts = geometry(found.guesses, places)
    copies = [*found.paths, *([found.dbc] if found.dbc and found.dbc != OURS else [])]
    with TemporaryDirectory(prefix="ballscrew-") as made, _named(Path(made), folder):
        draft = Path(made)
        (draft / RIG).write_text(_text(found, folder, parts), encoding="utf-8")
        for path in copies[len(found.paths) :]:
            shutil.copy(path, draft)
        rig = load_rig(draft)
        write_model(rig, found.guesses, draft)
        admit(load_model(draft / MODEL), rig)
        recording = read_recording(found.paths[0], rig)
        files = [name for name in (RIG, MODEL, EFFECTS) if (draft / name).exists()]
        _refuse(folder, files, copies, force)
        folder.mkdir(parents=True, exist_ok=True)
        for name in files:
            shutil.copy(draft / name, folder)
    for path in copies:
        if not _is_there(path, folder):
            shutil.copy(path, folder)
    told = (*files, *(path.name for path in copies))
    return NewRig(folder, parts, recording, told, any(guess.role == "heater" for guess in found.guesses))


@contextmanager
def _named(draft: Path, folder: Path) -> Iterator[None]:
    """Errors name the folder that was asked for, not the draft."""
    try:
        yield
    except SetupError as error:
        raise SetupError(str(error).replace(str(draft), str(folder))) from error


def _text(found: Found, folder: Path, parts: Geometry) -> str:
    first = found.sources[0]
    if isinstance(first, BusLog):
        scan = scan_of(first, found.guesses, found.tick_s)
        log = log_of_bus(first.dbc.path.name, first.bus, scan)
    else:
        log = log_of_csv(first.time_column, first.csv, first.guessed)
    names = ", ".join(path.name for path in found.paths[:4]) + (" ..." if len(found.paths) > 4 else "")
    return rig_text(folder.resolve().name or "new rig", names, found.tick_s, list(found.guesses), parts, log)


def _refuse(folder: Path, files: Sequence[str], copies: Sequence[Path], force: bool) -> None:
    """A SetupError where something else would be overwritten."""
    there = [name for name in files if (folder / name).exists()]
    there += [path.name for path in copies if (folder / path.name).exists() and not _is_there(path, folder)]
    if there and not force:
        raise SetupError(
            f"{folder}: has {', '.join(there)} already; --force overwrites, or choose another folder with -o"
        )


def _is_there(path: Path, folder: Path) -> bool:
    """Whether a file is in the folder already, the same."""
    other = folder / path.name
    return other.exists() and (other.samefile(path) or filecmp.cmp(path, other, shallow=False))


def unknown(new: NewRig) -> Iterator[tuple[str, str, str]]:
    """What no recording tells: what it is, what stands there now, and in which lines of rig.toml, or where else."""
    text = (new.folder / RIG).read_text(encoding="utf-8")
    for what, now, keys in new.parts.guessed():
        yield what, now, lines_of(text, keys)
    if new.heated:
        now = "at the thermometer that it warms most"
        yield "where each heater is", now, f"at in {MODEL}" if new.parts.screw else EFFECTS
