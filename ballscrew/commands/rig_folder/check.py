"""ballscrew check: a rig folder against its recordings, every doubt in one line."""

from collections.abc import Sequence
from pathlib import Path

import click

from ballscrew.doubts.doubt import Doubt
from ballscrew.doubts.doubts import Told, of_recording, of_the_folder, together
from ballscrew.options import PATH, terminal_options
from ballscrew.own_effect.patience import patience
from ballscrew.terminal import Terminal
from drivers.lab.estimates import is_estimates
from drivers.logs.logs import SUFFIXES
from drivers.recordings import find_recordings
from estimator.battery.admitted import admit
from estimator.errors import InputError, SetupError
from estimator.model import Model
from estimator.rig import Rig
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig


@click.command("check")
@click.argument("folder", type=PATH, metavar="FOLDER")
@click.argument("logs", nargs=-1, type=PATH, metavar="[LOG]...")
@terminal_options
def command(terminal: Terminal, folder: Path, logs: tuple[Path, ...]) -> int:
    """Look for what is wrong with the rig FOLDER beside each LOG; without one, beside the recordings in it.

    Messages that never come, temperatures that nobody named, units, ranges, the order of the thermometers, the tick,
    speed against position, the displacement against the warming, inputs that the model takes and nothing measures:
    each doubt in a line, with its place and what to do. Only what is clear is told: no doubt does not mean that all is
    right.
    """
    folder = folder.parent if folder.name == "rig.toml" else folder
    if folder.is_file():
        raise SetupError(f"{folder}: is a file; name the rig folder first, then recordings")
    if folder.is_dir() and not (folder / "rig.toml").exists():
        raise SetupError(f"{folder}: has no rig.toml; `ballscrew init LOG -o {folder}` writes a first one")
    rig = load_rig(folder)
    with patience(folder / "model.toml"):
        model = load_model(folder / "model.toml") if (folder / "model.toml").is_file() else Model({}, {})
        admit(model, rig)
    inside = [path for path in sorted(folder.iterdir()) if path.suffix.lower() in SUFFIXES]
    paths = find_recordings(logs or [path for path in inside if not is_estimates(path)])
    beside, failed = _beside(terminal, paths, rig, model)
    told = together([*(("", doubt) for doubt in of_the_folder(rig)), *beside])
    for one in told:
        terminal.say(_line(one, len(paths) - failed))
    count, of = f"{len(told) or 'no'} doubt{'s' * (len(told) > 1)}", len(paths) - failed
    terminal.say(f"{folder}: {count}; rig.toml and model.toml beside {of} recording{'s' * (of != 1)}")
    terminal.json([one.doubt._asdict() | {"recordings": one.recordings} for one in told])
    return InputError.exit_code if failed else 0


def _beside(terminal: Terminal, paths: Sequence[Path], rig: Rig, model: Model) -> tuple[list[tuple[str, Doubt]], int]:
    """Name and doubt of each recording, and how many could not be used."""
    found, failed = list[tuple[str, Doubt]](), 0
    with terminal.progress("reading", len(paths) or 1) as update:
        for k, path in enumerate(paths):
            update(k, path.name)
            try:
                found += [(path.name, doubt) for doubt in of_recording(path, rig, model)]
            except InputError as error:
                terminal.error(str(error))
                failed += 1
    return found, failed


def _line(one: Told, of: int) -> str:
    """place: doubt; fix (recordings)."""
    few = ", ".join(one.recordings[:3]) + (" ..." if len(one.recordings) > 3 else "")
    where = f" ({few})" if one.recordings and of > 1 else ""
    return f"{one.doubt.place}: {one.doubt.doubt}; {one.doubt.fix}{where}"
