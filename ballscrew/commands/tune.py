"""ballscrew tune: set a model's noise levels by recordings."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np

from ballscrew.options import logs_argument, output_options, rig_options, writable
from ballscrew.report.page import page
from ballscrew.terminal import Terminal
from ballscrew.threads import threads
from ballscrew.workspace import Loaded, load, open_model, open_rig, runs_of
from estimator.accuracy.quality import ChannelQuality, overall
from estimator.errors import InputError
from estimator.fit.tune import Tuned, tune
from estimator.model import Model
from estimator.rig import Rig
from estimator.rig_folder.model_toml import save_model

LEVELS = ("noise level", "of", "before", "after", "unit")
COLUMNS = ("channel", "NIS", "whiteness", "in 2 sd", "blind NIS", "blind 2 sd")
LEGEND = (
    "NIS: 1 when the noise is right; whiteness: largest autocorrelation within a minute, 0 when white",
    "in 2 sd: 95 % when honest; blind: of what is read after ten minutes without readings",
)
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
    terminal.say_if_compiling("passes", "loglike", "score", "ahead")
    with terminal.progress(f"tuning on {len(loaded)} recordings", None) as update, threads() as workers:
        found = tune(model, runs_of(rig, loaded, workers, update))
    save_model(found.model, out)
    _print(terminal, found)
    terminal.say(f"model: {out}")
    terminal.json(_as_json(found))
    if rrd is not None:
        _save(terminal, rrd, rig, model, loaded, found)
    return InputError.exit_code if failed else 0


def _print(terminal: Terminal, found: Tuned) -> None:
    terminal.table("", LEVELS, _levels(found))
    terminal.say("\nbefore->after")
    terminal.table("", COLUMNS, _channels(found))
    for sentence in (*LEGEND, *sentences(found)):
        terminal.say(sentence)


def _levels(found: Tuned) -> list[list[str]]:
    return [[x.path, x.kind, f"{x.before:.4g}", f"{x.after:.4g}", x.unit] for x in found.levels]


def _channels(found: Tuned) -> list[list[str]]:
    pairs = zip((*found.before, overall(found.before)), (*found.after, overall(found.after)), strict=True)
    return [_row(a, b) for a, b in pairs if b.readings]


def _save(terminal: Terminal, path: Path, rig: Rig, model: Model, loaded: Sequence[Loaded], found: Tuned) -> None:
    from ballscrew.report.tune_views import save_views  # rerun takes half a second to import

    levels = "Noise levels", sentences(found), [LEVELS, *_levels(found)]
    channels = "Innovations, before->after", LEGEND, [COLUMNS, *_channels(found)]
    save_views(path, rig, model, loaded, found, page([levels, channels]))
    terminal.say_views(path)


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
    stays = ", ".join(x.path for x in found.levels if x.kind == "measurement" and x.after == x.before)
    if stays:
        said.append(f"not lowered: {stays}; innovations there are not white, so part of a reading's error lasts")
    return said


def _row(a: ChannelQuality, b: ChannelQuality) -> list[str]:
    return [b.channel, *(_pair(getattr(a, key), getattr(b, key)) for key in FIGURES)]


def _pair(a: float, b: float) -> str:
    return f"{a:.2f}->{b:.2f}" if np.isfinite(b) else ""


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
