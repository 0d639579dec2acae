"""ballscrew tune: set a model's noise levels by recordings."""

from pathlib import Path

import click

from ballscrew.options import model_output, output_file, recording_workers, workspace_options
from ballscrew.report.sections import print_sections
from ballscrew.report.tune_report import as_json, save_views, sections
from ballscrew.report.use_report import print_use
from ballscrew.workspace import Workspace
from estimator.fit.tune import tune
from estimator.rig_folder.model_toml import save_model


@click.command("tune")
@model_output()
@output_file("--save", "rrd", metavar="OUT.rrd", help="Write innovations before and after as a rerun file.")
@recording_workers
@workspace_options
def command(work: Workspace, out: Path, rrd: Path | None, workers: int | str | None) -> int:
    """Set measurement and process noise of the model by all LOGs; every other parameter stays.

    Measurement noise is the most likely one a tick ahead. Process noise is the most likely one where nothing was read:
    that of the screw at thermometers left out, a third at a time, all other after ten minutes without readings. A tick
    ahead, errors that build up over minutes cannot be seen. A truth file is never opened.
    """
    work.read_once()
    work.terminal.say_if_compiling("passes", "loglike", "score", "ahead")
    with work.runs(f"tuning on {len(work.loaded)} recordings", None, processes=workers) as runs:
        tuned = tune(work.model, runs)
    save_model(tuned.model, out)
    print_sections(work.terminal, sections(tuned))
    print_use(work.terminal, tuned.uses, work.rig)
    work.terminal.say(f"model: {out}")
    work.terminal.json(as_json(tuned))
    if rrd is not None:
        save_views(rrd, work, tuned)
    return work.status
