"""ballscrew diagnose: whether a model is adequate, where it fails, and what the failure follows."""

from pathlib import Path

import click

from ballscrew.options import join_option, recording_workers, save_option, workspace_options
from ballscrew.report.diagnosis_report import as_json, print_diagnosis, sections
from ballscrew.report.sections import Section
from ballscrew.workspace import Workspace
from estimator.batch.trials import Trials
from estimator.events.events import events_of
from estimator.missing_heat.diagnose import diagnose


@click.command("diagnose")
@join_option
@save_option
@recording_workers
@workspace_options
def command(work: Workspace, join: bool, rrd: Path | None, workers: int | str | None) -> int:
    """Say whether a model is adequate for all LOGs, where it fails, and what the failure follows.

    What the model alone leaves is divided into heat that it lacks, by place and time, and errors of single readings;
    both are held against the speed, the drive, the time and every temperature that is measured. What begins within a
    run is told with its time. Nothing is fitted.
    """
    work.read(join=join)
    work.part()
    work.terminal.say_if_compiling("passes", "ahead")
    with work.runs("diagnosing", processes=workers) as runs:
        diagnosis = diagnose(work.model, runs)
        runs.progress("looking for what began within a run", 0.95)
        trials = Trials([found.misfit.trial for found in diagnosis.maps], runs.workers, diagnosis.uses)
        began = events_of(work.model, trials, runs)
    print_diagnosis(work.terminal, diagnosis, began)
    work.terminal.json(as_json(diagnosis, began))
    if rrd is not None:
        from ballscrew.report.comparison_views import save_views  # rerun takes half a second to import

        title = Section(f"{work.model.name}: diagnosis", diagnosis.sentences)
        save_views(rrd, work, [work.model], [title, *sections(diagnosis, began)])
    return work.status
