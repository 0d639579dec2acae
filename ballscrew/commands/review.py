"""ballscrew review: run the filter over recordings and say how good the estimate is."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import click

from ballscrew.machine import MachineVerdict
from ballscrew.muting import chosen_thermometers, muted
from ballscrew.options import (
    channel_options,
    join_option,
    save_option,
    table_option,
    view_option,
    workspace_options,
)
from ballscrew.report.review_report import as_json, print_reviews
from ballscrew.workspace import Loaded, Workspace
from estimator.accuracy.machine import Match
from estimator.accuracy.review import Review, review
from estimator.errors import InputError
from estimator.record import Recording
from estimator.state.gate import Mute


@click.command("review")
@join_option
@channel_options
@click.option(
    "--mute", "spans", multiple=True, metavar="NAME:FROM[-TO]",
    help="Do not use a channel, `telemeter` or `displacement` from FROM to TO: seconds from the start, or stop1 ...",
)  # fmt: skip
@table_option
@save_option
@view_option
@workspace_options
def command(
    work: Workspace, join: bool, channels: str | None, no_displacement: bool, spans: tuple[str, ...],
    table: Path | None, rrd: Path | None, view: bool,
) -> int:  # fmt: skip
    """Run the Kalman filter over each LOG and print how far its elongation is from the reference.

    Beside it: the model alone, the polyline through the thermometers, and two estimates that need no model. The
    reference is the truth where a NAME.truth.csv lies beside the log, else the displacement readings. A folder means
    all recordings in it.
    """
    names = chosen_thermometers(channels, work.rig)
    work.read(join=join)
    work.terminal.say_if_compiling("passes", "smoothed")
    judged = list(_judged(work, names, lambda recording: muted(recording, work.rig, names, no_displacement, spans)))
    if not judged:
        return work.status
    loaded, reviews, seconds = zip(*judged, strict=True)
    known = set(work.model.about.get("fitted_on", {}).values())
    fitted = [r.recording.fingerprint in known for r in reviews]
    verdict = MachineVerdict(work, work.model, Match([r.off_sd for r in reviews]), loaded)
    print_reviews(work.terminal, reviews, fitted, work.rig, verdict.sentence)
    work.terminal.json(as_json(reviews, fitted, seconds) | {"machine": verdict.as_json()})
    if table is not None:
        from ballscrew.table.columns import table as ticks  # pyarrow takes a while to import
        from ballscrew.table.file import write

        write(ticks(reviews, work.rig), table)
    if rrd is not None:
        from ballscrew.report.review_views import save_views  # rerun takes half a second to import

        save_views(rrd, work, loaded, reviews, verdict.sentence, view)
    return work.status


def _judged(
    work: Workspace, names: list[str] | None, mute_of: Callable[[Recording], Mute]
) -> Iterator[tuple[Loaded, Review, float]]:
    """Each recording that can be used, its review, and the seconds that it took."""
    for one in work.loaded:
        began = time.perf_counter()
        mute, truth = mute_of(one.recording), work.truth_of(one)
        try:
            with work.terminal.progress(one.recording.name, len(one.recording)) as update:
                found = review(one.recording, work.rig, work.model, truth, mute, names, update)
        except InputError as error:
            work.fail(error)
            continue
        yield one, found, time.perf_counter() - began
