"""Options that every command shares."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from estimator.errors import SetupError

STDOUT = "-"
MANY = ("--held-out", "--bus-kwargs")  # options that a shell's *.log may follow
INPUTS = {".log", ".blf", ".asc", ".trc", ".mf4", ".csv", ".toml"}


def json_apart(arguments: Sequence[str]) -> list[str]:
    """`--json [FILE]` may stand before a LOG: what looks like an input after it is not the FILE to overwrite."""
    apart = list(arguments)
    for i, word in enumerate(apart[:-1]):
        following = Path(apart[i + 1])
        if word == "--json" and following.suffix != ".json" and (following.suffix in INPUTS or following.is_dir()):
            apart[i] = f"--json={STDOUT}"
    return apart


def each_named(arguments: Sequence[str]) -> list[str]:
    """`--held-out A B C` means all three: every word up to the next option is named by the option before it."""
    named: list[str] = []
    option = ""
    for word in arguments:
        if word.startswith("-"):
            option = word if word in MANY else ""
            named.append(word)
        elif option and named[-1] != option:
            named += [option, word]
        else:
            named.append(word)
    return named


def writable(ctx: click.Context, param: click.Parameter, value: Path | str | None) -> Path | str | None:
    """An output file that can be written: asked before the work, not after it."""
    if value is None or value == STDOUT:
        return value
    path = Path(value)
    if not path.parent.is_dir():
        raise SetupError(f"{path}: there is no folder {path.parent}")
    if path.is_file() or path.is_dir() or not path.exists():
        _try_to_write(path)
    return value


def _try_to_write(path: Path) -> None:
    """Open the file without changing what is in it; a SetupError if that fails."""
    is_new = not path.exists()
    try:
        path.open("ab").close()
    except OSError as error:
        raise SetupError(f"{path}: cannot be written: {(error.strerror or str(error)).lower()}") from None
    if is_new:
        path.unlink()


def rig_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """--rig and --model, the same on every command."""
    model = click.option(
        "--model", "model_path", type=click.Path(path_type=Path), help="Model TOML; else the rig folder's model.toml."
    )
    rig = click.option(
        "--rig",
        "rig_path",
        type=click.Path(path_type=Path),
        help="Rig folder; else the nearest one at or above the first log that holds a rig.toml, else the built-in rig.",
    )
    return rig(model(command))


def output_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """--json, --quiet and --debug, the same on every command."""
    options = (
        click.option(
            "--json", "json_path", is_flag=False, flag_value=STDOUT, metavar="[FILE]", callback=writable,
            help="Write the result as JSON; to stdout without FILE, and the tables then go to stderr.",
        ),
        click.option("--quiet", is_flag=True, help="No tables, no progress; errors only."),
        click.option("--debug", is_flag=True, help="Show the traceback of an error."),
    )  # fmt: skip
    for option in reversed(options):
        command = option(command)
    return command


save_option = click.option(
    "--save", "rrd", type=click.Path(path_type=Path), callback=writable, metavar="OUT.rrd",
    help="Write the views as a rerun file.",
)  # fmt: skip
logs_argument = click.argument(
    "logs", nargs=-1, required=True, type=click.Path(path_type=Path, readable=False), metavar="LOG..."
)


def bus_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options, the same on every command that opens a bus."""
    options = (
        click.option("--interface", help="python-can interface: socketcan, pcan, vector, slcan, socketcand ..."),
        click.option("--channel", help="Channel of the interface, like can0."),
        click.option("--bitrate", type=int, help="Bit rate of the bus, 1/s."),
        click.option(
            "--bus-kwargs", multiple=True, metavar="K=V ...", help="Passed to the interface, like host=127.0.0.1."
        ),
    )
    for option in reversed(options):
        command = option(command)
    return command
