"""ballscrew fleet: all rigs of a plant, a row each."""

from collections.abc import Sequence
from pathlib import Path

import click

from ballscrew.fleet.fleet_report import as_json, print_fleet
from ballscrew.fleet.workers import each
from ballscrew.options import PATH, save_option, terminal_options, workers_option
from ballscrew.terminal import Terminal
from estimator.errors import InputError, SetupError


@click.command("fleet")
@click.argument("folders", nargs=-1, required=True, type=PATH, metavar="FOLDER...")
@workers_option("Processes that share the rigs; default: 1.", default=1)
@click.option("--suggest", "search", is_flag=True, help="Look for the missing effect too: minutes a rig.")
@save_option
@terminal_options
def command(terminal: Terminal, folders: Sequence[Path], workers: int | str, search: bool, rrd: Path | None) -> int:
    """Look at every rig FOLDER with its own model and recordings, and print a row for each.

    A folder without a rig.toml stands for the rig folders in it. A rig that cannot be used is a row with its reason.
    How the estimate follows is that of `review`, whether the model holds of `diagnose`, what drifts of `trend` (with
    six recordings or more). The views show the figures over time, the worst rig first.
    """
    rigs = [rig for folder in folders for rig in _rigs(folder)]
    terminal.say_if_compiling("passes", "smoothed", "ahead")
    with terminal.progress("looking at", len(rigs)) as update:
        found = []
        for one in each(rigs, workers, search):
            found.append(one)
            update(len(found), one.folder)
    found.sort(key=lambda one: [str(rig) for rig in rigs].index(one.folder))
    print_fleet(terminal, found)
    terminal.json(as_json(found))
    if rrd is not None:
        from ballscrew.fleet.fleet_views import save_views  # rerun takes half a second to import

        save_views(rrd, found)
        terminal.say_views(rrd)
    return InputError.exit_code if any(one.error or one.failed for one in found) else 0


def _rigs(folder: Path) -> list[Path]:
    """The rig folder, or those in it."""
    if (folder / "rig.toml").is_file():
        return [folder]
    found = sorted(file.parent for file in folder.glob("*/rig.toml"))
    if not found:
        raise SetupError(
            f"{folder}: no rig.toml in it, nor in a folder of it; `ballscrew init LOG -o FOLDER` makes one"
        )
    return found
