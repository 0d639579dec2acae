"""ballscrew fit: fit a model's parameters to recordings."""

from pathlib import Path

import click

from ballscrew.options import model_output, recording_workers, workspace_options
from ballscrew.report.fit_report import as_json, print_fit
from ballscrew.report.use_report import print_use
from ballscrew.terminal import INTERRUPTED
from ballscrew.workspace import Workspace
from estimator.fit.fit import fit
from estimator.rig_folder.model_toml import save_model


@click.command("fit")
@model_output()
@click.option("--learned", is_flag=True, help="Go on from what the model's own fit found, not from table values.")
@recording_workers
@workspace_options
def command(work: Workspace, out: Path, learned: bool, workers: int | str | None) -> int:
    """Fit the free parameters of the model to all LOGs at once.

    So that the model alone follows the measurements (least squares, open loop), as near to the table value of each
    parameter as they leave open; noise levels that are free then by likelihood. A truth file is never opened. What is
    fixed in the model file stays, and so does what has no table value and is like others in these recordings. Ctrl-C
    ends the search; the best model so far is written, if there is one.
    """
    work.read_once()
    work.terminal.say_if_compiling("passes", "score", "ahead")
    label = f"fitting {len(work.model.free())} parameters to {len(work.loaded)} recordings"
    with work.runs(label, None, processes=workers) as runs:
        fitted = fit(work.model, runs, learned)
    save_model(fitted.model, out)
    print_fit(work.terminal, fitted)
    print_use(work.terminal, fitted.uses, work.rig)
    work.terminal.say(f"model: {out}\nnext: ballscrew tune LOG... --model {out} -o {out}, for its noise levels")
    work.terminal.json(as_json(fitted))
    return INTERRUPTED if fitted.stopped else work.status
