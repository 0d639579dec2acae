"""ballscrew tune: set a model's noise levels by recordings."""

from __future__ import annotations

from pathlib import Path

import click

from ballscrew.options import logs_argument, model_output, output_file, rig_options, terminal_options
from ballscrew.report.tune_report import as_json, print_tuning, save_views
from ballscrew.terminal import Terminal
from ballscrew.workspace import open_workspace
from estimator.fit.tune import tune
from estimator.rig_folder.model_toml import save_model


@click.command("tune")
@logs_argument
@rig_options
@model_output()
@output_file("--save", "rrd", metavar="OUT.rrd", help="Write innovations before and after as a rerun file.")
@terminal_options
def command(
    terminal: Terminal, logs: tuple[Path, ...], rig_path: Path | None, model_path: Path | None, out: Path,
    rrd: Path | None,
) -> int:  # fmt: skip
    """Set measurement and process noise of the model by all LOGs; every other parameter stays.

    Measurement noise is the most likely one a tick ahead. Process noise is the most likely one after ten minutes
    without readings: a tick ahead, errors that build up over minutes cannot be seen. A truth file is never opened.
    """
    work = open_workspace(terminal, logs, rig_path, model_path)
    work.read(logs)
    terminal.say_if_compiling("passes", "loglike", "score", "ahead")
    with work.runs(f"tuning on {len(work.loaded)} recordings", None) as runs:
        found = tune(work.model, runs)
    save_model(found.model, out)
    print_tuning(terminal, found)
    terminal.say(f"model: {out}")
    terminal.json(as_json(found))
    if rrd is not None:
        save_views(rrd, work, found)
    return work.status
