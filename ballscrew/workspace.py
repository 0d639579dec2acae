"""What a command works on: the rig, the model and the recordings that its arguments name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files
from pathlib import Path

from ballscrew.terminal import Terminal
from drivers.logs.joined import Progress
from drivers.logs.truth import Truth, read_truth
from drivers.recordings import find_recordings, read_joined, read_recording
from estimator.errors import InputError, SetupError
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.work import Runs, Workers, silent

BUILT_IN = Path(str(files("recordings")))


@dataclass
class Loaded:
    """A recording, and where it came from."""

    path: Path
    recording: Recording

    @cached_property
    def truth(self) -> Truth | None:
        """The truth beside the recording, None without one: opened only by who prints errors."""
        return read_truth(self.path)


def open_rig(logs: Sequence[Path], rig_path: Path | None, terminal: Terminal) -> Rig:
    """The rig of --rig; else of the nearest folder at or above the first log; else the one that ships with us."""
    if rig_path is not None:
        return load_rig(rig_path.parent if rig_path.name == "rig.toml" else rig_path)
    first = (logs[0] if logs else Path()).resolve()
    for folder in (first, *first.parents):
        if (folder / "rig.toml").is_file():
            return load_rig(folder)
    terminal.say(f"no rig.toml at or above {first}: using the built-in rig, the paper's ball screw")
    return load_rig(BUILT_IN)


def open_model(rig: Rig, model_path: Path | None, terminal: Terminal) -> Model:
    """The model of --model, else of the rig folder; says so when it was fitted to another geometry or material."""
    path = model_path or rig.folder / "model.toml"
    if model_path is None and not path.is_file():
        raise SetupError(f"{rig.folder}: no model.toml beside rig.toml; write one or name it with --model FILE")
    model = load_model(path)
    fitted_rig = model.about.get("rig")
    if fitted_rig not in (None, rig.fingerprint()):
        terminal.warn(f"{path} was fitted to another geometry or material than {rig.folder / 'rig.toml'}; fit it again")
    return model


def load(logs: Sequence[Path], rig: Rig, terminal: Terminal, join: bool = False) -> tuple[list[Loaded], list[str]]:
    """Read all recordings; those that cannot be used are reported, and returned as messages, the others still serve.

    `join`: the logs are parts of one recording.
    """
    paths = find_recordings(logs)
    if not paths:
        raise InputError(f"{', '.join(map(str, logs))}: the truth of a simulated recording, not a recording")
    recordings = [paths] if join else [[path] for path in paths]
    loaded, failed = [], []
    with terminal.progress("reading", len(recordings)) as update:
        for i, parts in enumerate(recordings):
            name = parts[0].name
            update(i, name)
            try:
                loaded.append(_read(parts, rig, lambda share, i=i, name=name: update(i + share, name)))
            except InputError as error:
                failed.append(str(error))
    for message in failed:
        terminal.error(message)
    return loaded, failed


def _read(parts: Sequence[Path], rig: Rig, progress: Progress) -> Loaded:
    if len(parts) == 1:
        return Loaded(parts[0], read_recording(parts[0], rig, progress))
    return Loaded(*read_joined(parts, rig, progress))


def true_elongation(one: Loaded, terminal: Terminal, failed: list[str]) -> Array | None:
    """True elongation at the ticks, (K,) um; a malformed truth file is reported, and the readings serve instead."""
    try:
        return one.truth.at(one.recording.time_s) if one.truth else None
    except InputError as error:
        terminal.error(str(error))
        failed.append(str(error))
        one.truth = None
        return None


def load_apart(
    logs: Sequence[Path], held_out: Sequence[Path], rig: Rig, terminal: Terminal
) -> tuple[list[Loaded], list[Loaded], list[str]]:
    """The recordings to use, those held out, and what could not be read; one that is in both is held out."""
    loaded, failed = load(logs, rig, terminal)
    if not held_out:
        return loaded, [], failed
    apart, failed_too = load(held_out, rig, terminal)
    kept = {one.recording.fingerprint for one in apart}
    rest = [one for one in loaded if one.recording.fingerprint not in kept]
    if loaded and not rest:
        terminal.warn("every recording is held out: all are used all the same, and what is held out says nothing new")
    elif len(rest) < len(loaded):
        both = [one.path.name for one in loaded if one.recording.fingerprint in kept]
        terminal.say(f"held out, and so not used: {', '.join(both)}")
    return rest or loaded, apart, [*failed, *failed_too]


def runs_of(
    rig: Rig, loaded: Sequence[Loaded], workers: Workers = map, bar: Callable[[float, str], None] | None = None
) -> Runs:
    """What was loaded, as workers take it; a bar shows how far they are."""
    progress = (lambda stage, done: bar(done, stage)) if bar else silent
    return Runs(rig, [one.recording for one in loaded], workers, progress)
