"""ballscrew review: run the filter over recordings and say how good the estimate is."""

from functools import partial
from pathlib import Path

import click

from ballscrew.options import save_option, table_option, view_option, workers_option, workspace_options
from ballscrew.page.iso230.positions import over_stroke
from ballscrew.report.review_report import as_json, print_reviews
from ballscrew.reviewing import Asked, review_options
from ballscrew.workspace import Workspace


@click.command("review")
@review_options
@table_option
@save_option
@view_option
@workers_option("Processes that share the recordings; default: 1.", 1)
@workspace_options
def command(work: Workspace, asked: Asked, table: Path | None, rrd: Path | None, view: bool, workers: int | str) -> int:
    """Run the Kalman filter over each LOG and print how far its elongation is from the reference.

    Beside it: the model alone, the polyline through the thermometers, and two estimates that need no model. The
    reference is the truth where a NAME.truth.csv lies beside the log, else the displacement readings. A folder means
    all recordings in it.
    """
    places = partial(over_stroke, rig=work.rig) if rrd is not None else lambda _: ()
    found = asked.reviewed(work, places, workers)
    if found is None:
        return work.status
    reviews, verdict = found.reviews, found.verdict
    if table is not None:  # before anything is printed: who reads that may leave after a line
        from ballscrew.table.table import table as ticks, write  # pyarrow takes a while to import

        write(ticks(reviews, work.rig, len(reviews) + len(found.failed) > 1), table)
    print_reviews(work.terminal, reviews, found.fitted, work.rig, verdict.sentence)
    work.terminal.json(as_json(reviews, found.fitted, found.seconds) | {"machine": verdict.as_json()})
    if rrd is not None:
        from ballscrew.report.review_views import save_views  # rerun takes half a second to import

        save_views(rrd, work, found.loaded, reviews, verdict.sentence, view)
    return work.status
