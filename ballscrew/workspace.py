"""What a command works on: the rig, the models and the recordings that its arguments name."""

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from importlib.resources import files
from pathlib import Path

import click
import numpy as np

from ballscrew.doubts.guesses import guesses
from ballscrew.own_effect.patience import patience
from ballscrew.terminal import Terminal
from ballscrew.workers.processes import enough, working
from drivers.logs.joined import Progress
from drivers.logs.truth import Truth, read_truth
from drivers.recordings import find_recordings, read_joined, read_recording
from estimator.battery.admitted import admit
from estimator.errors import InputError, SetupError
from estimator.inputs.untold import stretches
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.work import Runs, Workers

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


@dataclass
class Workspace:
    """A rig and a model, the recordings to use and those held out, and what could not be used, in words.

    logs, rig_path  as they were named
    """

    terminal: Terminal
    rig: Rig
    model: Model
    logs: Sequence[Path] = ()
    rig_path: Path | None = None
    loaded: list[Loaded] = field(default_factory=list)
    held_out: list[Loaded] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)

    @property
    def recordings(self) -> list[Recording]:
        """Those to use."""
        return [one.recording for one in self.loaded]

    @contextmanager
    def runs(self, label: str, total: float | None = 1.0, processes: int | str | None = 1) -> Iterator[Runs]:
        """The recordings to use, with their workers, and a bar that shows how far the work is.

        `processes` share them, or the workers of a scheduler; None: as many processes as serve recordings so long
        """
        with self.terminal.progress(label, total) as update, working(processes or self.processes) as workers:
            yield Runs(self.rig, self.recordings, workers, lambda stage, done: update(done, stage))

    @property
    def processes(self) -> int:
        """How many serve recordings so long."""
        return enough([float(one.time_s[-1] - one.time_s[0]) for one in self.recordings])

    @property
    def status(self) -> int:
        """What the command ends with when all else went well."""
        return InputError.exit_code if self.failed else 0

    def read(self, held_out: Sequence[Path] = (), join: bool = False) -> None:
        """Read the logs; ends the command where none can be used. One that is in both is held out.

        `join`: the logs are parts of one recording.
        """
        self.loaded, self.failed = load(self.logs, self.rig, self.terminal, join)
        if held_out:
            self.held_out, failed = load(held_out, self.rig, self.terminal)
            self.failed += failed
            self._take_out()
        if not self.loaded:
            raise click.exceptions.Exit(InputError.exit_code)

    def read_once(self, held_out: Sequence[Path] = ()) -> None:
        """The same, but a copy of a recording is used once: it would count as another witness, and as one left out."""
        self.read(held_out)
        first: dict[str, Loaded] = {}
        for one in self.loaded:
            if (same := first.setdefault(one.recording.fingerprint, one)) is not one:
                self.terminal.warn(f"{one.recording.name} is {same.recording.name} once more: used once")
        self.loaded = list(first.values())
        self.part()

    def part(self) -> None:
        """Take recordings in the stretches in which it is known what was done, each as one of its own."""
        self.loaded, self.held_out = self._parted(self.loaded), self._parted(self.held_out)

    def _parted(self, loaded: Sequence[Loaded]) -> list[Loaded]:
        found = []
        for one in loaded:
            parts = stretches(one.recording, self.rig)
            if parts[0] is not one.recording:
                spans = " and ".join(f"{part.time_s[0]:.0f} to {part.time_s[-1]:.0f} s" for part in parts)
                lost = "the drive was not told" if "speed" in self.rig.inputs else "nothing was read"
                self.terminal.warn(f"{one.recording.name}: {lost} for long; used from {spans}, from a start of its own")
            found += [Loaded(one.path, part) for part in parts]
        return found

    def read_besides(self, logs: Sequence[Path]) -> list[Loaded]:
        """More recordings of the same machine, of which at least one must be of use."""
        found, failed = load(logs, self.rig, self.terminal)
        self.failed += failed
        if not found:
            raise click.exceptions.Exit(InputError.exit_code)
        return found

    def _take_out(self) -> None:
        """Use nothing of what is held out."""
        kept = {one.recording.fingerprint for one in self.held_out}
        both = [one for one in self.loaded if one.recording.fingerprint in kept]
        if self.loaded and len(both) == len(self.loaded):
            self.terminal.warn(
                "every recording is held out: all are used all the same, and what is held out says nothing new"
            )
        elif both:
            self.terminal.say(f"held out, and so not used: {', '.join(one.path.name for one in both)}")
            self.loaded = [one for one in self.loaded if one.recording.fingerprint not in kept]

    def fail(self, error: InputError) -> None:
        """Go on without what cannot be used."""
        self.terminal.error(str(error))
        self.failed.append(str(error))

    def truth_of(self, one: Loaded) -> Array | None:
        """True elongation at the ticks, (K,) um; a malformed truth file is reported, and the readings serve instead."""
        try:
            true_um = one.truth.at(one.recording.time_s) if one.truth else None
        except InputError as error:
            self.fail(error)
            one.truth = None
            return None
        from_start = one.recording.part_of and self.rig.zero_C is None
        return true_um - true_um[0] if true_um is not None and from_start else true_um


def open_workspace(
    terminal: Terminal, logs: Sequence[Path], rig_path: Path | None, model_path: Path | None
) -> Workspace:
    """The rig and the model; the logs are still to be read."""
    rig = open_rig(logs, rig_path, terminal)
    return Workspace(terminal, rig, open_model(rig, model_path, terminal), logs, rig_path)


def open_rig(logs: Sequence[Path], rig_path: Path | None, terminal: Terminal) -> Rig:
    """The rig of --rig; else of the nearest folder at or above the first log; else the one that ships with us."""
    if rig_path is not None:
        return _looked_at(load_rig(rig_path), terminal)
    first = (logs[0] if logs else Path()).resolve()
    for folder in (first, *first.parents):
        if (folder / "rig.toml").is_file():
            return _looked_at(load_rig(folder), terminal)
    terminal.say(f"no rig.toml at or above {first}: using the built-in rig, the paper's ball screw")
    return load_rig(BUILT_IN)


def _looked_at(rig: Rig, terminal: Terminal) -> Rig:
    """The rig; said where parts of it are guesses still: what follows may be their fault, and no sensor's."""
    if at := guesses(rig.folder):
        place = (
            f"{rig.folder / 'rig.toml'}: {len(at)} lines, the first in line {at[0]}, are guesses of `ballscrew init`"
        )
        terminal.warn(f"{place}: figures, and sensors that are accused, may be their fault")
    return rig


def open_model(rig: Rig, model_path: Path | None, terminal: Terminal) -> Model:
    """The model of --model, else of the rig folder, if it fits; says so when it was fitted to another geometry."""
    path = model_path or rig.folder / "model.toml"
    if model_path is None and not path.is_file():
        raise SetupError(f"{rig.folder}: no model.toml beside rig.toml; write one or name it with --model FILE")
    with patience(path):
        model = load_model(path)
        admit(model, rig)
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
                loaded.append(_read(parts, rig, partial(lambda i, name, share: update(i + share, name), i, name)))
            except InputError as error:
                failed.append(str(error))
    for message in failed:
        terminal.error(message)
    _name_apart(loaded)
    for one in loaded:
        if np.isfinite(one.recording.channels[:, rig.is_thermometer]).any():  # or an error will say it
            for doubt in one.recording.doubts:
                terminal.warn(f"{one.path.name}: {doubt}")
    return loaded, failed


def _name_apart(loaded: Sequence[Loaded]) -> None:
    """Name recordings of one name, as two days may have them, with their folders too."""
    named = Counter(one.recording.name for one in loaded)
    for one in loaded:
        if named[one.recording.name] > 1:
            one.recording = replace(one.recording, name=f"{one.recording.name} ({one.path.parent})")


def _read(parts: Sequence[Path], rig: Rig, progress: Progress) -> Loaded:
    if len(parts) == 1:
        return Loaded(parts[0], read_recording(parts[0], rig, progress))
    return Loaded(*read_joined(parts, rig, progress))


def runs_of(rig: Rig, loaded: Sequence[Loaded], workers: Workers = map) -> Runs:
    """What was loaded, as workers take it."""
    return Runs(rig, [one.recording for one in loaded], workers)
