"""Options that every command shares."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

STDOUT = "-"
RECORDING_SUFFIXES = {".log", ".blf", ".asc", ".trc", ".mf4", ".csv"}


class JsonOption(click.Option):
    """`--json [FILE]`: stdout without FILE. What follows is taken for a recording if it looks like one.

    Otherwise `review --json run.log` would overwrite the log it was asked to read.
    """

    def process_value(self, ctx: click.Context, value: Any) -> Any:
        value = super().process_value(ctx, value)
        if value is not None and value != STDOUT and Path(value).suffix in RECORDING_SUFFIXES:
            raise click.UsageError(f"--json {value} would overwrite a recording; put --json last or name a .json file")
        return value


def rig_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """--rig and --model, the same on every command."""
    model = click.option(
        "--model", "model_path", type=click.Path(path_type=Path), help="Model TOML; else the rig folder's model.toml."
    )
    rig = click.option(
        "--rig",
        "rig_path",
        type=click.Path(path_type=Path),
        help="Rig folder; else the nearest folder at or above the first log that holds a rig.toml, else the built-in rig.",
    )
    return rig(model(command))


def output_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """--json, --quiet and --debug, the same on every command."""
    options = (
        click.option(
            "--json", "json_path", cls=JsonOption, is_flag=False, flag_value=STDOUT, metavar="[FILE]",
            help="Write the result as JSON; to stdout without FILE, and the tables then go to stderr.",
        ),
        click.option("--quiet", is_flag=True, help="No tables, no progress; errors only."),
        click.option("--debug", is_flag=True, help="Show the traceback of an error."),
    )  # fmt: skip
    for option in reversed(options):
        command = option(command)
    return command


logs_argument = click.argument("logs", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="LOG...")
