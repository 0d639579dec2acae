"""ballscrew diagnose: whether a model is adequate, where it fails, and what the failure follows."""

from __future__ import annotations

from pathlib import Path

import click

from ballscrew.options import logs_argument, rig_options, save_option, terminal_options
from ballscrew.report.diagnosis_report import as_json, print_diagnosis, sections
from ballscrew.report.page import Section
from ballscrew.terminal import Terminal
from ballscrew.workspace import open_workspace
from estimator.missing_heat.diagnose import diagnose


@click.command("diagnose")
@logs_argument
@rig_options
@save_option
@terminal_options
def command(
    terminal: Terminal, logs: tuple[Path, ...], rig_path: Path | None, model_path: Path | None, rrd: Path | None
) -> int:
    """Say whether a model is adequate for all LOGs, where it fails, and what the failure follows.

    What the model alone leaves is divided into heat that it lacks, by place and time, and errors of single readings;
    both are held against the speed, the drive, the time and every temperature that is measured. Nothing is fitted.
    """
    work = open_workspace(terminal, logs, rig_path, model_path)
    work.read(logs)
    terminal.say_if_compiling("passes", "ahead")
    with work.runs("diagnosing") as runs:
        found = diagnose(work.model, runs)
    print_diagnosis(terminal, found)
    terminal.json(as_json(found))
    if rrd is not None:
        from ballscrew.report.comparison_views import save_views  # rerun takes half a second to import

        title = Section(f"{work.model.name}: diagnosis", found.sentences)
        save_views(rrd, work, [work.model], [title, *sections(found)])
    return work.status
