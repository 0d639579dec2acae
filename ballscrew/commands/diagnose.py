"""ballscrew diagnose: whether a model is adequate, where it fails, and what the failure follows."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np

from ballscrew.commands.compare import KEYS
from ballscrew.commands.fit import HORIZONS
from ballscrew.options import logs_argument, output_options, rig_options, save_option
from ballscrew.report.page import Section
from ballscrew.terminal import Terminal
from ballscrew.threads import threads
from ballscrew.workspace import load, open_model, open_rig, runs_of
from estimator.accuracy.quality import overall
from estimator.errors import InputError
from estimator.inputs.phase import PHASES
from estimator.missing_heat.diagnose import Diagnosis, diagnose
from estimator.missing_heat.missing_heat import MissingHeat
from estimator.missing_heat.where import Missing
from estimator.missing_heat.wrong_reading import Wrong


@click.command("diagnose")
@logs_argument
@rig_options
@save_option
@output_options
def command(
    logs: tuple[Path, ...], rig_path: Path | None, model_path: Path | None, rrd: Path | None, json_path: str | None,
    quiet: bool, debug: bool,
) -> int:  # fmt: skip
    """Say whether a model is adequate for all LOGs, where it fails, and what the failure follows.

    What the model alone leaves is divided into heat that it lacks, by place and time, and errors of single readings;
    both are held against the speed, the drive, the time and every temperature that is measured. Nothing is fitted.
    """
    terminal = Terminal(json_path, quiet)
    rig = open_rig(logs, rig_path, terminal)
    model = open_model(rig, model_path, terminal)
    loaded, failed = load(logs, rig, terminal)
    if not loaded:
        return InputError.exit_code
    terminal.say_if_compiling("passes", "ahead")
    with terminal.progress("diagnosing", 1.0) as update, threads() as workers:
        found = diagnose(model, runs_of(rig, loaded, workers, update))
    _print(terminal, found, tables := _sections(found))
    terminal.json(_as_json(found))
    if rrd is not None:
        from ballscrew.report.comparison_views import save_views  # rerun takes half a second to import

        save_views(terminal, rrd, rig, [model], loaded, [(f"{model.name}: diagnosis", found.sentences, ()), *tables])
    return InputError.exit_code if failed else 0


def _print(terminal: Terminal, found: Diagnosis, tables: Sequence[Section]) -> None:
    for i, (title, said, (head, *rows)) in enumerate(tables):
        if i:
            terminal.say("\n" + "; ".join([title, *said]))
        terminal.table("", head, rows)
    white = overall(found.quality)
    worst = max(found.quality, key=lambda each: np.nan_to_num(each.whiteness))
    told = f"; largest autocorrelation of what it did not expect {white.whiteness:.2f} ({worst.channel})"
    terminal.say(
        f"\nfilter: NIS {white.nis:.2f} per channel, {100 * white.in_2sd:.0f} % in 2 sd"
        + (told if np.isfinite(white.whiteness) else "")
    )
    for sentence in found.sentences:
        terminal.say(sentence)


def _sections(found: Diagnosis) -> list[Section]:
    """The tables: errors, missing heat, wrong readings."""
    rows = [
        [title, _number(error.temperature_K, 3), _number(error.elongation_um, 2)]
        for title, error in [(HORIZONS[key], found.errors[key]) for key in HORIZONS]
    ]
    rows.append(["sensors alone", f"{found.floor.temperature_K:.3f}", _number(found.floor.elongation_um, 2)])
    rows.append(["good enough alone", f"{found.limits.temperature_K:.3f}", _number(found.limits.elongation_um, 2)])
    tables: list[Section] = [("how far ahead", (), [["error, rms", "K", "um"], *rows])]
    if found.where:
        head = ["place", "when", "W", "sd", "follows", "p"]
        said = ["what it would take to repair the run, mean over all recordings"]
        tables.append(("missing heat", said, [head, *map(_heat_row, found.where)]))
    if found.readings:
        head = ["channel", "offset", "sd", "rms", "unit", "follows", "p"]
        tables.append(("wrong readings", ["what no heat explains"], [head, *map(_reading_row, found.readings)]))
    return tables


def _heat_row(each: Missing) -> list[str]:
    place = each.node if each.node is not None else f"{each.from_mm:.0f} - {each.to_mm:.0f} mm"
    return [
        place, PHASES[each.phase], f"{each.heat_W:+.2f}", f"{each.sd_W:.2f}", each.follows.name or "",
        f"{each.follows.p:.3f}",
    ]  # fmt: skip


def _reading_row(each: Wrong) -> list[str]:
    return [
        each.channel, f"{each.offset:+.3f}", f"{each.sd:.3f}", f"{each.rms:.3f}", each.unit, each.follows.name or "",
        f"{each.follows.p:.3f}",
    ]  # fmt: skip


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if np.isfinite(value) else ""


def _as_json(found: Diagnosis) -> dict[str, object]:
    return {
        "adequate": found.adequate,
        "where": [
            {
                "from_mm": each.from_mm, "to_mm": each.to_mm, "node": each.node, "phase": each.phase,
                "heat_W": each.heat_W, "sd_W": each.sd_W, "follows": each.follows.name, "p": each.follows.p,
                "explains": each.follows.explains, "effect": each.effect,
            }
            for each in found.where
        ],
        "readings": [
            {
                "channel": each.channel, "offset": each.offset, "sd": each.sd, "unit": each.unit, "rms": each.rms,
                "follows": each.follows.name, "p": each.follows.p, "explains": each.follows.explains,
                "effect": each.effect,
            }
            for each in found.readings
        ],
        "sentences": list(found.sentences),
        "errors": {KEYS[key]: vars(error) for key, error in found.errors.items()},
        "noise_floor": vars(found.floor),
        "good_enough": {"temperature_K": found.limits.temperature_K, "elongation_um": found.limits.elongation_um},
        "whiteness": [vars(each) for each in found.quality],
        "missing_heat": {each.misfit.trial.recording.name: _map(each) for each in found.maps},
    }  # fmt: skip


def _map(each: MissingHeat) -> dict[str, object]:
    return {
        "zones": [{"from_mm": zone.from_mm, "to_mm": zone.to_mm, "node": zone.node} for zone in each.zones],
        "blocks": [
            {"phase": phase, "at_s": at, "seconds": seconds}
            for phase, at, seconds in zip(each.blocks.phase, each.blocks.at_s, each.blocks.seconds, strict=True)
        ],
        "heat_W_m": each.mean,
        "sd_W_m": each.sd,
    }
