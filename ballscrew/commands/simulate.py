"""ballscrew simulate: make a recording of the rig that is not there, or play it on a bus."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ballscrew.completion import experiments, plants, words
from ballscrew.muting import seconds
from ballscrew.options import bus_options, rig_option, terminal_options, writable
from ballscrew.terminal import Terminal, duration
from drivers.bus.bus import FAILURES, BusAddress, told
from drivers.canbus import can
from drivers.logs.log_writer import check_format
from estimator.errors import SetupError

if TYPE_CHECKING:
    from drivers.encoded import Encoded
    from drivers.virtual_rig import Run  # here and below: what it is compiled with takes a while to import

OWN_DBC = "rig.dbc"  # of the package: what the simulated rig sends by itself


class Seconds(click.ParamType[float]):
    """A time such as 2h, 90min, 45s or plain seconds."""

    name = "time"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        try:
            return seconds(str(value))
        except ValueError:
            self.fail(f"'{value}' is no time; write 2h, 90min, 45s or seconds", param, ctx)


def _checked(ctx: click.Context, param: click.Parameter, value: Path | None) -> Path | None:
    """A recording that can be written; its folder is made."""
    if value is not None:
        check_format(value)
        try:
            value.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise SetupError(f"{value.parent}: cannot be made: {(error.strerror or str(error)).lower()}") from None
        writable(ctx, param, value)
    return value


@click.command("simulate")
@click.argument("name", metavar="NAME", shell_complete=words(experiments))
@click.option(
    "-o", "out", type=click.Path(path_type=Path), metavar="FILE", callback=_checked,
    help="Recording to write; its suffix says the format: .log, .blf, .asc, .trc or .mf4.",
)  # fmt: skip
@bus_options
@rig_option("Rig folder whose rig.toml and DBC say what is on the bus; else the rig that ships.")
@click.option(
    "--machine", type=click.IntRange(min=0), default=0, show_default=True, metavar="N",
    help="0: the paper's machine; N: another of the same build, its constants drawn by N.",
)  # fmt: skip
@click.option("--seed", default=1, show_default=True, help="The same seed is the same rig with the same noise.")
@click.option(
    "--plant", multiple=True, metavar="EFFECT[=STRENGTH]", shell_complete=words(plants),
    help="Switch an effect on; strength 1 is nominal.",
)  # fmt: skip
@click.option("--without", multiple=True, metavar="EFFECT", shell_complete=words(plants), help="Switch an effect off.")
@click.option(
    "--onset",
    type=Seconds(),
    default="0",
    metavar="TIME",
    help="What is planted heats, cools and disturbs channels from then on.",
)
@click.option(
    "--max-drive", type=Seconds(), default="2h", show_default=True, help="Stop each drive after this at latest."
)
@click.option(
    "--cycles", type=click.IntRange(min=1), default=2, show_default=True,
    help="Drives, each with a stop of 60 min after it.",
)  # fmt: skip
@click.option(
    "--seconds", type=click.FloatRange(min=0.0, min_open=True), metavar="S", help="Cut the run after this time."
)
@click.option(
    "--date", type=click.DateTime(["%Y-%m-%d", "%Y-%m-%dT%H:%M", "%Y-%m-%dT%H:%M:%S"]), metavar="DATE",
    help="When the run began, like 2026-11-03 or 2026-11-03T06:30, local time.",
)  # fmt: skip
@click.option(
    "--speed-up", type=click.FloatRange(min=0.0, min_open=True), default=1.0, show_default=True,
    help="On a bus: times faster than the rig.",
)  # fmt: skip
@terminal_options
def command(
    terminal: Terminal, name: str, out: Path | None, bus: BusAddress | None, rig_path: Path | None, machine: int,
    seed: int, plant: tuple[str, ...], without: tuple[str, ...], onset: float, max_drive: float, cycles: int,
    seconds: float | None, date: datetime | None, speed_up: float,
) -> None:  # fmt: skip
    """Simulate experiment NAME: a pattern FS, CS or ES and a speed in m/min, like FS-20 or CS-2.5.

    The table is driven until the screw has grown by about 50 um, stands still for 60 min, and is driven again. The
    truth is kept beside the recording, as FILE with the suffix .truth.csv, and the constants of the machine with the
    suffix .machine.json.
    """
    if out is not None and bus is not None:
        raise click.UsageError("either -o FILE for a recording, or --interface for a bus, not both")
    if out is None and bus is None:
        raise click.UsageError("say where to: -o FILE for a recording, or --interface for a bus")
    if date is not None and (bus is not None or not 1980 <= date.year < 2100):
        raise click.UsageError("--date is of a recording, from 1980 to 2099: frames on a bus are of now")
    run = _simulate(
        terminal, name, machine=machine, seed=seed, plant=dict(_strength(word) for word in plant), without=without,
        onset_s=onset, max_drive_s=max_drive, cycles=cycles, seconds=seconds,
    )  # fmt: skip
    encoded = _encoded(run, rig_path) if rig_path else None
    if out is not None:
        terminal.json(_write(terminal, run, encoded, out, {"began_s": date.timestamp()} if date else {}))
    if bus is not None:
        _play(terminal, run, encoded, bus, speed_up)


def _simulate(terminal: Terminal, name: str, **options: Any) -> Run:
    from drivers.virtual_rig import simulate

    with terminal.progress(name, None) as update:
        try:
            return simulate(name, progress=lambda t, um: update(t, f"{duration(t)}, {um:.1f} um"), **options)
        except ValueError as error:
            raise SetupError(str(error)) from error


def _encoded(run: Run, rig_path: Path) -> Encoded | None:
    """How the run looks on another bus; None where that is the one of the rig that ships."""
    from ballscrew.workspace import BUILT_IN
    from drivers.decode.dbc import find_dbc
    from drivers.encoded import Encoded
    from estimator.rig_folder.rig_folder import load_rig

    rig = load_rig(rig_path)
    own = find_dbc(OWN_DBC, BUILT_IN)
    return None if find_dbc(rig.log.dbc, rig.folder).read_bytes() == own.read_bytes() else Encoded(run, rig)


def _strength(word: str) -> tuple[str, float]:
    effect, _, strength = word.partition("=")
    try:
        return effect, float(strength or 1.0)
    except ValueError:
        raise SetupError(f"--plant {word}: '{strength}' is no number; write {effect}=0.5") from None


def _write(
    terminal: Terminal, run: Run, encoded: Encoded | None, path: Path, began: dict[str, float]
) -> dict[str, Any]:
    from drivers.virtual_rig import write

    try:
        encoded.write(path, **began) if encoded else write(run, path, **began)
    except ValueError as error:
        raise SetupError(f"{path}: {error}") from error
    length, growth = float(run.truth.time_s[-1]), float(run.truth.elongation_um.max())
    terminal.say(f"{path}: {duration(length)}, {path.stat().st_size / 1e6:.1f} MB, grew by at most {growth:.1f} um")
    return {
        "path": str(path),
        "seconds": length,
        "max_elongation_um": growth,
        "planted": run.planted,
        "onset_s": run.onset_s,
        "machine": run.machine.number,
    }


def _play(terminal: Terminal, run: Run, encoded: Encoded | None, address: BusAddress, speed_up: float) -> None:
    from drivers.virtual_rig import frame_table, play

    try:
        bus = address.open()
    except FAILURES as error:
        raise SetupError(f"{address}: {told(error)}") from error
    terminal.say(f"playing {run.name} on {address}, {speed_up:g} x the rig's time; Ctrl-C stops")
    with bus:
        try:
            play(encoded.messages(0.0) if encoded else frame_table(run).messages(0.0), bus, speed_up)
        except (can.CanError, OSError) as error:
            raise SetupError(f"{address}: the bus is gone: {told(error)}") from error
