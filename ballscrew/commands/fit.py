"""ballscrew fit: fit a model's parameters to recordings."""

from __future__ import annotations

from pathlib import Path

import click

from ballscrew.options import logs_argument, model_output, rig_options, terminal_options
from ballscrew.report.fit_report import as_json, print_fit
from ballscrew.terminal import INTERRUPTED, Terminal
from ballscrew.workspace import open_workspace
from estimator.fit.fit import fit
from estimator.rig_folder.model_toml import save_model


@click.command("fit")
@logs_argument
@rig_options
@model_output()
@terminal_options
def command(
    terminal: Terminal, logs: tuple[Path, ...], rig_path: Path | None, model_path: Path | None, out: Path
) -> int:
    """Fit the free parameters of the model to all LOGs at once.

    First so that the model alone follows the measurements (least squares, open loop), then by maximum likelihood; what
    predicts better ten minutes ahead is kept. A truth file is never opened. Parameters marked fixed in the model file
    stay, and so do those that these recordings cannot tell from others. Ctrl-C ends the search; the best model so far
    is written, if there is one.
    """
    work = open_workspace(terminal, logs, rig_path, model_path)
    work.read(logs)
    terminal.say_if_compiling("passes", "loglike", "score", "gram", "ahead")
    label = f"fitting {len(work.model.free())} parameters to {len(work.loaded)} recordings"
    with work.runs(label, None) as runs:
        found = fit(work.model, runs)
    save_model(found.model, out)
    print_fit(terminal, found)
    terminal.say(f"model: {out}")
    terminal.json(as_json(found))
    return INTERRUPTED if found.stopped else work.status
