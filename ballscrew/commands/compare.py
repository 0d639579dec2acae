"""ballscrew compare: models against recordings, beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np

from ballscrew.commands.fit import HORIZONS
from ballscrew.options import logs_argument, output_options, save_option
from ballscrew.report.page import Section
from ballscrew.terminal import Terminal
from ballscrew.threads import threads
from ballscrew.workspace import load, open_model, open_rig, true_elongation
from estimator.accuracy.compare import ByHorizon, Comparison, compare
from estimator.accuracy.floor import Error
from estimator.errors import InputError
from estimator.inputs.phase import PHASES
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.work import Runs

KEYS = {"one_step": "one_step", "ahead": "ahead_10min", "open_loop": "open_loop"}


@click.command("compare")
@logs_argument
@click.option(
    "--rig", "rig_path", type=click.Path(path_type=Path),
    help="Rig folder; else the nearest one at or above the first log that holds a rig.toml, else the built-in rig.",
)  # fmt: skip
@click.option(
    "--model", "model_paths", type=click.Path(path_type=Path), multiple=True,
    help="Model TOML, once for each model to compare; else the rig folder's model.toml.",
)  # fmt: skip
@save_option
@output_options
def command(
    logs: tuple[Path, ...], rig_path: Path | None, model_paths: tuple[Path, ...], rrd: Path | None,
    json_path: str | None, quiet: bool, debug: bool,
) -> int:  # fmt: skip
    """Print how far one or more models are from the readings in all LOGs: where, when, and how far ahead.

    The elongation is compared with the truth where a NAME.truth.csv lies beside the log, else with the readings. One
    tick ahead, ten minutes ahead, and by the model alone from the first sample on; by channel, by phase and by
    speed, with what the sensors alone would leave beside it. The views show one model, or two: before and after.
    """
    if rrd is not None and len(model_paths) > 2:
        raise click.UsageError("--save shows one model, or two beside each other")
    terminal = Terminal(json_path, quiet)
    rig = open_rig(logs, rig_path, terminal)
    models = [open_model(rig, path, terminal) for path in (model_paths or (None,))]
    loaded, failed = load(logs, rig, terminal)
    if not loaded:
        return InputError.exit_code
    terminal.say_if_compiling("passes", "ahead")
    truths = [true_elongation(one, terminal, failed) for one in loaded]
    found = _compared(terminal, rig, models, [one.recording for one in loaded], truths)
    _print(terminal, tables := sections(found))
    terminal.json({"models": [_as_json(each) for each in found]})
    if rrd is not None:
        from ballscrew.report.comparison_views import save_views  # rerun takes half a second to import

        save_views(terminal, rrd, rig, models, loaded, tables)
    return InputError.exit_code if failed else 0


def _compared(
    terminal: Terminal, rig: Rig, models: Sequence[Model], recordings: Sequence[Recording],
    truths: Sequence[Array | None],
) -> list[Comparison]:  # fmt: skip
    found = []
    with terminal.progress("comparing", len(models)) as update, threads() as workers:
        for done, model in enumerate(models):
            update(done, model.name)
            found.append(compare(model, Runs(rig, recordings, workers), truths))
    return found


def _print(terminal: Terminal, tables: Sequence[Section]) -> None:
    for i, (title, _, (head, *rows)) in enumerate(tables):
        if i:
            terminal.say(f"\n{title}")
        terminal.table("", head, rows)
    for _, said, _ in tables:
        for sentence in said:
            terminal.say(sentence)


def _reference(found: Comparison) -> list[str]:
    """What the elongation was compared with; nothing where it was with nothing."""
    parts, rest = ["the truth"] if found.truths else [], found.recordings - found.truths
    if rest and "displacement" in found.by_channel:
        read = "the displacement readings, and at rest the direct reading joined at the stop"
        parts.append(f"{read} ({rest} of {found.recordings} recordings)" if found.truths else read)
    return [f"elongation compared with {'; '.join(parts)}"] if parts else []


def sections(found: Sequence[Comparison]) -> list[Section]:
    """The tables: by horizon, by phase and speed, by channel."""
    names = [each.name for each in found]
    head = ["", *(cell for name in names for cell in (f"{name}, K", "um"))]
    rows = [[title, *_cells([each.whole[key] for each in found])] for key, title in HORIZONS.items()]
    rows.append(["sensors alone", *_cells([each.floor for each in found])])
    if any(each.held_out for each in found):
        rows.append(["held out: model alone", *_cells([_held_out(each) for each in found])])
    said = [*_reference(found[0]), *(f"{each.name}: {warning}" for each in found for warning in each.warnings)]
    parts = {PHASES[p]: [each.by_phase[p] for each in found] for p in PHASES}
    parts |= {f"at {v:g} m/min": [each.by_speed[v] for each in found] for v in found[0].by_speed}
    alone = [[title, *_cells([e["open_loop"] for e in errors])] for title, errors in parts.items()]
    return [
        ("how far ahead", said, [["error, rms", *head[1:]], *rows]),
        ("by the model alone (open loop)", (), [head, *alone]),
        _by_channel(found, names),
    ]


def _by_channel(found: Sequence[Comparison], names: Sequence[str]) -> Section:
    shown = list(HORIZONS) if len(found) == 1 else ["open_loop"]
    head = ["1 tick", "10 min", "alone"] if len(found) == 1 else names
    title = "channels, rms in K or um" + ("" if len(found) == 1 else ", by the model alone")
    return title, (), [["channel", *head], *(_channel(found, name, shown) for name in found[0].by_channel)]


def _held_out(each: Comparison) -> Error:
    return each.held_out["open_loop"] if each.held_out else Error(float("nan"), float("nan"))


def _cells(errors: list[Error]) -> list[str]:
    return [cell for e in errors for cell in (_number(e.temperature_K, 3), _number(e.elongation_um, 2))]


def _channel(found: Sequence[Comparison], name: str, horizons: list[str]) -> list[str]:
    return [name, *(_number(each.by_channel[name][key], 3) for each in found for key in horizons)]


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if np.isfinite(value) else ""


def _as_json(each: Comparison) -> dict[str, object]:
    return {
        "name": each.name,
        **_horizons(each.whole),
        "held_out": vars(_held_out(each)) if each.held_out else None,
        "by_channel": {n: {KEYS[key]: e for key, e in by.items()} for n, by in each.by_channel.items()},
        "by_phase": {phase: _horizons(by) for phase, by in each.by_phase.items()},
        "by_speed_m_min": {f"{speed:g}": _horizons(by) for speed, by in each.by_speed.items()},
        "noise_floor": vars(each.floor),
        "reference": {"truth": each.truths, "readings": each.recordings - each.truths},
        "warnings": list(each.warnings),
    }


def _horizons(errors: ByHorizon) -> dict[str, object]:
    return {KEYS[key]: vars(error) for key, error in errors.items()}
