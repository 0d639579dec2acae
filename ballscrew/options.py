"""Options that several commands share, and what they make of words on the command line."""

import re
from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import Any

import click

from ballscrew.completion import thermometers, words
from ballscrew.terminal import STDOUT, Terminal
from drivers.lab.estimates import is_estimates
from estimator.errors import SetupError

Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]

PATH = click.Path(path_type=Path)
MANY = ("--held-out", "--healthy", "--bus-kwargs")  # options that a shell's *.log may follow
INPUTS = {".log", ".blf", ".asc", ".trc", ".mf4", ".csv", ".toml"}
TABLES = (".csv", ".parquet")
NEAREST_RIG = "else the nearest one at or above the first log that holds a rig.toml, else the built-in rig."


class Workers(click.ParamType[int | str]):
    """A number of processes, or the address of a Dask scheduler."""

    name = "workers"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int | str:
        """The number, or the address as it is."""
        if isinstance(value, str) and re.fullmatch(r"tcp://.+:\d+", value):
            return value
        try:
            return click.IntRange(min=1).convert(value, param, ctx)
        except click.BadParameter:
            self.fail(f"{value!r} is neither a number of processes nor tcp://HOST:PORT", param, ctx)


def json_apart(arguments: Sequence[str]) -> list[str]:
    """`--json [FILE]` may stand before a LOG: what looks like an input after it is not the FILE to overwrite."""
    apart = list(arguments)
    for i, word in enumerate(apart[:-1]):
        following = Path(apart[i + 1])
        if word == "--json" and following.suffix != ".json" and (following.suffix in INPUTS or following.is_dir()):
            apart[i] = f"--json={STDOUT}"
    return apart


def all_named(arguments: Sequence[str]) -> list[str]:
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


def writable_result(ctx: click.Context, param: click.Parameter, value: Path | str | None) -> Path | str | None:
    """An output file that is no recording: none is overwritten by a slip."""
    if value is not None and value != STDOUT and Path(value).suffix.lower() in INPUTS - {".toml"}:
        raise SetupError(f"{'/'.join(param.opts)} {value}: the name of a recording; choose another")
    return writable(ctx, param, value)


def writable_table(ctx: click.Context, param: click.Parameter, value: Path | None) -> Path | str | None:
    """A table's file: its name says in which format. No CSV but a table is overwritten: it may be a recording."""
    checked = writable_as(f"a table is written as one of {', '.join(TABLES)}", *TABLES)(ctx, param, value)
    is_there = value is not None and value.suffix.lower() == ".csv" and value.is_file() and value.stat().st_size > 0
    if value is not None and is_there and not is_estimates(value):
        raise SetupError(f"--table {value}: is there, and is no table of `review`; choose another name")
    return checked


def writable_as(what: str, *suffixes: str) -> Callable[..., Any]:
    """A file whose name says what it is, so that no recording is overwritten by a slip."""

    def checked(ctx: click.Context, param: click.Parameter, value: Path | None) -> Path | str | None:
        file = writable(ctx, param, value)
        if value is not None and value.suffix.lower() not in suffixes:
            raise SetupError(f"{param.opts[0]} {value}: {what}")
        return file

    return checked


def _try_to_write(path: Path) -> None:
    """Open the file without changing what is in it; a SetupError if that fails."""
    is_new = not path.exists()
    try:
        path.open("ab").close()
    except OSError as error:
        raise SetupError(f"{path}: cannot be written: {(error.strerror or str(error)).lower()}") from None
    if is_new:
        path.unlink()


def stacked(*options: Decorator) -> Decorator:
    """Several options as one decorator, in the order of the help."""

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


def output_file(*names: str, **more: Any) -> Decorator:
    """A file that the command writes."""
    return click.option(*names, **dict[str, Any](type=PATH, callback=writable_result) | more)


def views_file(help: str) -> Decorator:
    """The views, as rerun reads them."""
    checked = writable_as("views are written as .rrd", ".rrd")
    return click.option("--save", "rrd", type=PATH, metavar="OUT.rrd", callback=checked, help=help)


def model_output(help: str = "Write the model here.") -> Decorator:
    """-o MODEL."""
    return output_file("-o", "out", metavar="MODEL", required=True, help=help)


def rig_option(help: str) -> Decorator:
    """--rig."""
    return click.option("--rig", "rig_path", type=PATH, help=help)


def model_option(help: str) -> Decorator:
    """--model."""
    return click.option("--model", "model_path", type=PATH, help=help)


def terminal_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """--json, --quiet and --debug, the same on every command, which gets a `terminal` that heeds them."""

    @wraps(command)
    def with_terminal(json_path: str | None, quiet: bool, debug: bool, **given: Any) -> Any:
        return command(Terminal(json_path, quiet), **given)

    return stacked(
        click.option(
            "--json", "json_path", is_flag=False, flag_value=STDOUT, metavar="[FILE]", callback=writable_result,
            help="Write the result as JSON; to stdout without FILE, and the tables then go to stderr.",
        ),
        click.option("--quiet", is_flag=True, help="No tables, no progress; errors only."),
        click.option("--debug", is_flag=True, help="Show the traceback of an error."),
    )(with_terminal)  # fmt: skip


def bus_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Where a bus is, the same on every command that opens one: it gets `bus`, None without --interface."""

    @wraps(command)
    def with_bus(
        *passed: Any, interface: str | None, channel: str | None, bitrate: int | None, bus_kwargs: tuple[str, ...],
        **given: Any,
    ) -> Any:  # fmt: skip
        from drivers.bus import bus  # python-can takes a while to import

        address = bus.BusAddress(interface, channel, bitrate, bus.bus_options(bus_kwargs))
        return command(*passed, bus=address if interface is not None else None, **given)

    return stacked(
        click.option("--interface", help="python-can interface: socketcan, pcan, vector, slcan, socketcand ..."),
        click.option("--channel", help="Channel of the interface, like can0."),
        click.option("--bitrate", type=int, help="Bit rate of the bus, 1/s."),
        click.option(
            "--bus-kwargs", multiple=True, metavar="K=V ...", help="Passed to the interface, like host=127.0.0.1."
        ),
    )(with_bus)


def workspace_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """LOG..., --rig, --model and the terminal's options on a command, which gets `work`: its logs are to be read."""

    @logs_argument
    @rig_options
    @terminal_options
    @wraps(command)
    def with_workspace(terminal: Terminal, logs: Sequence[Path], rig_path: Any, model_path: Any, **given: Any) -> Any:
        from ballscrew.workspace import open_workspace  # the estimator takes a while to import

        return command(open_workspace(terminal, logs, rig_path, model_path), **given)

    return with_workspace


logs_argument = click.argument(
    "logs", nargs=-1, required=True, type=click.Path(path_type=Path, readable=False), metavar="LOG..."
)
rig_options = stacked(  # --rig and --model
    rig_option(f"Rig folder; {NEAREST_RIG}"),
    model_option("Model TOML; else the rig folder's model.toml."),
)


def workers_option(help: str, default: int | None = None) -> Decorator:
    """--workers."""
    both = f"{help} Or the address of a Dask scheduler, whose workers do it. The result is the same."
    return click.option("--workers", type=Workers(), default=default, metavar="N|tcp://HOST:PORT", help=both)


recording_workers = workers_option("Processes that share the recordings; default: one a core where these are long.")
save_option = views_file("Write the views as a rerun file.")
table_option = click.option(
    "--table", type=PATH, metavar="OUT.csv|.parquet", callback=writable_table,
    help="Write what was measured and estimated, a row a tick.",
)  # fmt: skip
view_option = click.option("--view", is_flag=True, help="Open the views in the rerun viewer, where there is a screen.")
channel_options = stacked(
    click.option(
        "--channels", metavar="2,4,..", shell_complete=words(thermometers, listed=True),
        help="Use only these thermometers, by number or name; default: all.",
    ),
    click.option("--no-displacement", is_flag=True, help="Do not use the displacement readings."),
)  # fmt: skip
join_option = click.option(
    "--join", is_flag=True, help="The LOGs are parts of one recording: one estimate runs through them."
)
search_options = stacked(
    click.option(
        "--held-out", "held_out", multiple=True, type=PATH, metavar="LOG",
        help="A recording, or folder of them, that is never used to choose or fit, only reported; may be repeated.",
    ),
    click.option(
        "--effects", "own", multiple=True, metavar="FILE.py[:Class]",
        help="Effects of your own to try as well. The file is Python, and runs.",
    ),
    output_file(
        "--compose", metavar="FILE.py",
        help="Write what no catalogue has into this file, as an effect, after what is there.",
    ),
)  # fmt: skip
