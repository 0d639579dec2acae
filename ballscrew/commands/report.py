"""ballscrew report: a review as one HTML file, to hand on."""

from collections.abc import Sequence
from pathlib import Path

import click

from ballscrew.options import PATH, workspace_options, writable_as
from ballscrew.page.headline import headline
from ballscrew.page.iso230 import drift_section, positions
from ballscrew.page.iso230.drift import Drift, drift
from ballscrew.page.page import made_by, page, write
from ballscrew.page.review_page import sections, title
from ballscrew.report.review_report import as_json
from ballscrew.reviewing import Asked, Reviewed, review_options
from ballscrew.workspace import Workspace
from estimator.errors import SetupError
from estimator.record import Recording
from estimator.rig import Rig


@click.command("report")
@click.option(
    "-o", "out", type=PATH, default="report.html", show_default=True, metavar="OUT.html",
    callback=writable_as("a page is written as .html", ".html", ".htm"), help="Write the page here.",
)  # fmt: skip
@click.option(
    "--iso230-3", "iso", is_flag=True, help="With the drift of the axis after ISO 230-3, at positions of the table."
)
@click.option(
    "--at", "at", metavar="MM,MM[,MM]",
    help="These positions of the table, two or three; default: the ends of the stroke and its middle.",
)  # fmt: skip
@review_options
@workspace_options
def command(work: Workspace, asked: Asked, out: Path, iso: bool, at: str | None) -> int:
    """Review each LOG and write what came of it as one page: for the screen, light and dark, and for paper.

    Figures, pictures, equations and what was not used, in one HTML file that needs no network. With --iso230-3 also how
    far the axis drifts at fixed positions while it is driven and while it cools, by the truth where a NAME.truth.csv
    lies beside the log, else by the estimate: with and without compensation.
    """
    if at is not None and not iso:
        raise click.UsageError("--at names the positions of --iso230-3: give both")
    named = _positions(work.rig, at) if iso else []
    found = asked.reviewed(work, lambda recording: _places(recording, work.rig, named, iso))
    if found is None:
        return work.status
    with work.terminal.progress("drawing", len(found.reviews)) as update:
        drifts = _drifts(work, found, named) if iso else []
        drifting = [drift_section.section(drifts)] if iso else []
        made = made_by(f"{work.rig.name}, {found.verdict.model.name}", "report")
        lead = headline(found, work.rig)
        write(page(title(found), made, lead, sections(found, work.rig, drifting, update)), out)
    _tell(work, lead, drifts)
    work.terminal.say(f"report: {out}")
    figures = as_json(found.reviews, found.fitted, found.seconds)
    work.terminal.json({
        "report": str(out), "headline": lead, "overall": figures["overall"], "held_out": figures["held_out"],
        "machine": found.verdict.as_json(), "iso230_3": drift_section.as_json(drifts) if iso else None,
    })  # fmt: skip
    return work.status


def _positions(rig: Rig, at: str | None) -> list[float]:
    """The positions that --at names; none: those of each recording's stroke. A rig that has none is a SetupError."""
    if rig.screw is None or rig.nut is None:
        raise SetupError(
            f"--iso230-3 is of an axis: {rig.folder / 'rig.toml'} has no [screw] with a [nut]; leave it out"
        )
    return positions.positions(at, rig) if at is not None else []


def _places(recording: Recording, rig: Rig, named: Sequence[float], iso: bool) -> list[float]:
    """Where the error at the table is to be told: at positions asked for, and over the stroke."""
    asked = (named or positions.ends_and_middle(recording)) if iso else []
    return [*asked, *positions.over_stroke(recording, rig)]


def _drifts(work: Workspace, found: Reviewed, named: Sequence[float]) -> list[Drift]:
    """Of each recording; one in which the table never moved has none."""
    drifts = []
    for one, review in zip(found.loaded, found.reviews, strict=True):
        if at := named or positions.ends_and_middle(one.recording):
            drifts.append(drift(review, one.truth, at))
        else:
            work.terminal.warn(f"{one.recording.name}: its table never moved; name positions with --at MM,MM")
    return drifts


def _tell(work: Workspace, lead: Sequence[str], drifts: Sequence[Drift]) -> None:
    for sentence in lead:
        work.terminal.say(sentence)
    for one in drifts:
        work.terminal.say(f"\n{one.recording.name}: drift of the axis. {drift_section.meaning(one)}")
        work.terminal.table(drift_section.table(one))
