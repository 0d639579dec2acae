"""The `ballscrew` command: finds the subcommands, and turns our own errors into one line and an exit status."""

import atexit
import gc
import importlib
import os
import sys

import click

from ballscrew.options import all_named, json_apart
from ballscrew.terminal import INTERRUPTED
from estimator.errors import BallscrewError

COMMANDS = {
    "init": "Make a rig folder that works from recordings.",
    "check": "Look for what is wrong with a rig folder beside its recordings.",
    "simulate": "Make a recording of the rig that is not there.",
    "live": "Monitor a rig on a CAN bus.",
    "hub": "Share a CAN bus between programs, without CAN hardware.",
    "review": "Run the filter over recordings and say how good the estimate is.",
    "report": "Write a review as one page to hand on, HTML.",
    "fit": "Fit a model's parameters to recordings.",
    "tune": "Set a model's noise levels by recordings.",
    "compare": "Print how far models are from recordings, side by side.",
    "diagnose": "Say whether a model is adequate, and where it fails.",
    "suggest": "Say which physical effect is missing from a model.",
    "improve": "Add to a model what is missing, effect by effect.",
    "trend": "Say what wears: a machine's parameters over weeks.",
    "fleet": "Look at all rigs of a plant, a row each.",
    "export": "Convert logs of CAN frames to another format.",
    "show": "Print a model as equations, with values, bounds and sources.",
    "effects": "Print the catalogue of effects, or one of them; check one.",
    "add": "Add an effect to a model.",
    "new-effect": "Write an effect of your own into a file, ready to be changed.",
    "warm": "Compile the filter before it is needed.",
}
FOLDERS = {"rig_folder": ("init", "check"), "catalogue": ("effects", "show", "add", "new-effect")}  # in commands/


def module_of(name: str) -> str:
    """Where a command is."""
    folder = next((f"{folder}." for folder, names in FOLDERS.items() if name in names), "")
    return f"ballscrew.commands.{folder}{name.replace('-', '_')}"


class Commands(click.Group):
    """Subcommands by name, each imported when it is used: `ballscrew --help` answers at once."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command = importlib.import_module(module_of(cmd_name)).command
        assert isinstance(command, click.Command)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.command(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="ballscrew")
def root() -> None:
    """Thermal elongation of a ball screw from temperatures in its bore and a few displacement readings.

    A rig folder holds rig.toml (geometry, channels, signals), model.toml (the physics and its parameters) and
    recordings. Start with:  ballscrew simulate FS-20 -o FS-20.log  and  ballscrew review FS-20.log
    """


def main() -> None:
    """Entry point: exit 0 done, 1 an input could not be used, 2 wrong usage, rig or model, 130 Ctrl-C."""
    debug = "--debug" in sys.argv
    atexit.register(gc.freeze)  # to take apart what is left costs a third of a second, on a busy machine three
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # threads take twice as long on 30 states; numpy reads it once
    try:
        status = root.main(all_named(json_apart(sys.argv[1:])), "ballscrew", standalone_mode=False)
    except click.ClickException as error:
        error.show()
        status = 2
    except (click.Abort, KeyboardInterrupt):
        click.echo("stopped by Ctrl-C", err=True)
        status = INTERRUPTED
    except BallscrewError as error:
        if debug:
            raise
        click.echo(f"error: {error}", err=True)
        status = error.exit_code
    sys.exit(status if isinstance(status, int) else 0)
