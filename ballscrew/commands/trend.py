"""ballscrew trend: how a machine's parameters change from run to run, over weeks."""

import click

from ballscrew.options import recording_workers, workspace_options
from ballscrew.report.trend_report import as_json, print_trend
from ballscrew.report.use_report import print_use
from ballscrew.workspace import Workspace
from estimator.trend.trend import trend


@click.command("trend")
@recording_workers
@workspace_options
def command(work: Workspace, workers: int | str | None) -> int:
    """Say which parameters of a model change over LOGs of one machine: what wears, since when, how fast.

    Each run tells every parameter by itself, with what the model's fit knows of the others. A parameter is named where
    a step or a rise explains more of its values than their order by chance would, in one of twenty machines that do not
    change. The LOGs are taken in the order of their clocks; there must be six at least.
    """
    work.read_once()
    work.terminal.say_if_compiling("passes", "ahead")
    with work.runs("following", processes=workers) as runs:
        found = trend(work.model, runs)
    print_trend(work.terminal, found)
    print_use(work.terminal, found.uses, work.rig)
    work.terminal.json(as_json(found))
    return work.status
