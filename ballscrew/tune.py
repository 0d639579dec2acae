"""ballscrew tune: set a model's noise levels by recordings."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from ballscrew.options import logs_argument, output_options, rig_options, writable
from ballscrew.terminal import Terminal
from ballscrew.threads import threads
from ballscrew.workspace import load, open_model, open_rig
from estimator.errors import InputError
from estimator.model import save_model
from estimator.quality import ChannelQuality
from estimator.tune import Tuned, tune

COLUMNS = ("before -> after", "NIS", "whiteness", "in 2 sd", "NIS, blind", "in 2 sd, blind")
FIGURES = ("nis", "whiteness", "in_2sd", "blind_nis", "blind_in_2sd")


@click.command("tune")
@logs_argument
@rig_options
@click.option(
    "-o", "out", type=click.Path(path_type=Path), required=True, callback=writable, metavar="MODEL",
    help="Write the model here.",
)  # fmt: skip
@click.option(
    "--save", "rrd", type=click.Path(path_type=Path), callback=writable, metavar="OUT.rrd",
    help="Write innovations before and after as a rerun file.",
)  # fmt: skip
@output_options
def command(
    logs: tuple[Path, ...], rig_path: Path | None, model_path: Path | None, out: Path, rrd: Path | None,
    json_path: str | None, quiet: bool, debug: bool,
) -> int:  # fmt: skip
    """Set measurement and process noise of the model by all LOGs; every other parameter stays.

    Measurement noise is the most likely one a tick ahead. Process noise is the most likely one after ten minutes
    without readings: a tick ahead, errors that build up over minutes cannot be seen. A truth file is never opened.
    """
    terminal = Terminal(json_path, quiet)
    rig = open_rig(logs, rig_path, terminal)
    model = open_model(rig, model_path, terminal)
    loaded, failed = load(logs, rig, terminal)
    if not loaded:
        return InputError.exit_code
    terminal.say_if_compiling()
    with terminal.progress(f"tuning on {len(loaded)} recordings", None) as update, threads() as share:
        found = tune(
            model, rig, [one.recording for one in loaded],
            lambda stage, n, value: update(n, f"{stage}, run {n}: log-likelihood {value:.1f}"), share,
        )  # fmt: skip
    save_model(found.model, out)
    _print(terminal, found)
    terminal.say(f"model: {out}")
    terminal.json(_as_json(found))
    return InputError.exit_code if failed else 0


def _print(terminal: Terminal, found: Tuned) -> None:
    rows = [[x.path, x.kind, f"{x.before:.4g}", f"{x.after:.4g}", x.unit] for x in found.levels]
    terminal.table("", ["noise level", "of", "before", "after", "unit"], rows)
    terminal.say()
    pairs = zip(found.before, found.after, strict=True)
    terminal.table("", COLUMNS, [_row(a, b) for a, b in pairs if b.readings])
    terminal.say("\nNIS: 1 when the noise is right; whiteness: largest autocorrelation within a minute, 0 when white")
    terminal.say("in 2 sd: 95 % when honest; blind: of what is read after ten minutes without readings")
    for sentence in sentences(found):
        terminal.say(sentence)


def sentences(found: Tuned) -> list[str]:
    """What a person should know of the outcome."""
    said = []
    if np.isfinite(found.missing):
        off = found.errors["open_loop"].temperature_K
        said.append(
            f"noise stands in for missing physics here: the model alone is {off:.2f} K off, {found.missing:.1f} times"
            " what its sensors leave; look for the missing effect first"
        )
    loud = [x.path for x in found.levels if x.kind == "process" and x.after > 3 * x.before]
    if loud:
        said.append(f"process noise rose {found.factor:.1f} times: the model explains less than it claimed")
    return said


def _row(a: ChannelQuality, b: ChannelQuality) -> list[str]:
    return [b.channel, *(_pair(getattr(a, key), getattr(b, key)) for key in FIGURES)]


def _pair(a: float, b: float) -> str:
    return f"{a:.2f} -> {b:.2f}" if np.isfinite(b) else ""


def _as_json(found: Tuned) -> dict[str, object]:
    levels = {x.path: {"of": x.kind, "before": x.before, "after": x.after, "unit": x.unit} for x in found.levels}
    channels = {
        b.channel: {key: {"before": getattr(a, key), "after": getattr(b, key)} for key in FIGURES}
        for a, b in zip(found.before, found.after, strict=True)
    }
    errors = {key: vars(error) for key, error in found.errors.items()}
    return {
        "levels": levels, "channels": channels, "errors": errors, "noise_floor": vars(found.floor),
        "process_factor": found.factor, "missing_physics": found.missing, "sentences": sentences(found),
    }  # fmt: skip
