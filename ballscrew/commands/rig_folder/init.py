"""ballscrew init: make a rig folder that works from recordings."""

import os
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from ballscrew.new_rig.bus_log import OURS
from ballscrew.new_rig.new_rig import RIG, Found, NewRig, find, unknown, write
from ballscrew.new_rig.seen import Guess
from ballscrew.options import PATH, logs_argument, terminal_options
from ballscrew.terminal import Terminal, duration
from drivers.frames import few
from drivers.recordings import find_recordings
from estimator.errors import InputError, SetupError
from estimator.rig_folder.rig_folder import load_rig

CHECKED = ("scan_crc", "scan_number", "checksums", "counters")  # of [log]: written where they hold
_SHOWN = 12  # of what is not used


@click.command("init")
@logs_argument
@click.option("-o", "folder", type=PATH, required=True, metavar="FOLDER", help="The rig folder to write.")
@click.option("--dbc", type=PATH, metavar="FILE.dbc", help="What the frames of a CAN log mean.")
@click.option("--places", metavar="MM,MM,..", help="Where the thermometers are along the screw, in their order.")
@click.option("--force", is_flag=True, help="Overwrite what is in FOLDER.")
@terminal_options
def command(
    terminal: Terminal, logs: tuple[Path, ...], folder: Path, dbc: Path | None, places: str | None, force: bool
) -> None:
    """Make a rig folder that works from each LOG: CAN frames with their DBC, a lab CSV, or an MF4 of signals.

    It looks at what is in the recordings, guesses what is a thermometer, the speed, the position and so on, and writes
    rig.toml with every guess marked, a first model.toml, and copies of the recordings. What no recording tells, such as
    places and diameters, has a value that can be used: edit it. A folder as LOG means all recordings in it.
    """
    paths = find_recordings(logs)
    if not paths:
        raise InputError(f"{', '.join(map(str, logs))}: the truth of a simulated recording, not a recording")
    if dbc is not None and not dbc.is_file():
        raise SetupError(f"--dbc {dbc}: no such file")
    if folder.exists() and not folder.is_dir():
        raise SetupError(f"-o {folder}: is a file; name a folder")
    with terminal.progress("reading", 1.0) as update:
        found = find(paths, dbc, update)
        new = write(found, folder, _places(places), force)
    _print(terminal, found, new)
    rows = [_row(guess) for guess in found.guesses]
    keys = ("name", "signal", "rate_hz", "lo", "hi", "unit", "taken_as", "why", "or")
    terminal.json({
        "folder": str(folder), "files": list(new.files), "tick_s": found.tick_s,
        "signals": [dict(zip(keys, row, strict=True)) for row in rows],
        "not_used": [one.source for one in found.unused],
        "unknown": [{"what": what, "now": now, "lines": lines} for what, now, lines in unknown(new)],
        "next": list(_next(folder)),
    })  # fmt: skip


def _places(text: str | None) -> list[float]:
    try:
        return [float(word) for word in (text or "").replace(";", ",").split(",") if word.strip()]
    except ValueError:
        raise SetupError(f"--places {text}: numbers of mm with commas between, such as 0,72.5,127") from None


def _row(guess: Guess) -> tuple[Any, ...]:
    first, *more = guess.seen
    why = "".join(f"with {one.label}, " for one in more) + guess.why
    also = [one.source for one in guess.also]
    return guess.name, first.source, first.rate_hz, *first.usual, first.unit, guess.role, why, also


def _print(terminal: Terminal, found: Found, new: NewRig) -> None:
    ticks = new.recording
    terminal.say(
        f"{found.paths[0].name}: {_kind(found)}, {len(found.seen)} signals, {duration(float(ticks.time_s[-1]))}, "
        f"{len(ticks)} ticks of {found.tick_s:g} s"
    )
    head = ["signal" if found.dbc else "column", "rate, 1/s", "range", "taken as", "why"]
    rows = [_texts(guess) for guess in found.guesses]
    terminal.table([head, *rows], prose=4)
    log = load_rig(new.folder).log
    if log.closes:
        held = [key for key in CHECKED if getattr(log, key)]
        terminal.say(f"a tick closes with {log.closes}" + (f"; right on this log: {', '.join(held)}" if held else ""))
    if found.unused:
        terminal.say(f"taken for no measured value: {few([one.source for one in found.unused], _SHOWN)}")
    if found.never:
        terminal.say(f"messages of {found.dbc.name if found.dbc else ''} that never came: {few(found.never, _SHOWN)}")
    if found.dbc == OURS:
        terminal.say("these are the built-in rig's ids: if it is that screw, `ballscrew review LOG` needs no folder")
    terminal.say()
    terminal.say(f"{new.folder / RIG} is written, with every guess marked. What no recording tells:")
    terminal.table([["to edit", "lines", "now"], *([what, lines, now] for what, now, lines in unknown(new))], prose=2)
    if new.parts.at_mm and not new.parts.told:
        terminal.say(
            "All places at once:  ballscrew init ... --force --places 0,50,...  with a number for each thermometer"
        )
    terminal.say()
    for k, line in enumerate(_next(new.folder)):
        terminal.say(f"{'next:' if k == 0 else '     '} {line}")


def _kind(found: Found) -> str:
    """What the recordings are."""
    if found.dbc:
        return f"CAN frames, read with {found.dbc.name}"
    return "a lab CSV" if found.paths[0].suffix.lower() == ".csv" else "decoded signals"


def _texts(guess: Guess) -> list[str]:
    name, source, rate, low, high, unit, role, why, also = _row(guess)
    why += f"; or {', '.join(also[:3])}" if also else ""
    taken = f"{role} {name}" if role in ("thermometer", "heater", "temperature") else role
    return [source, f"{rate:.3g}", f"{low:.4g} ... {high:.4g} {unit}".rstrip(), taken, why]


def _next(folder: Path) -> Iterator[str]:
    """The next three commands, as they are typed here."""
    at, fitted = (shlex.quote(os.fspath(path)) for path in (folder, folder / "fitted.toml"))
    yield f"ballscrew review {at}"
    yield f"ballscrew fit {at} -o {fitted}"
    yield f"ballscrew review {at} --model {fitted}"
