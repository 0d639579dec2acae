"""ballscrew improve: add to a model what is missing, effect by effect, as long as that helps."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click

from ballscrew.options import (
    model_output,
    output_file,
    recording_workers,
    search_options,
    view_option,
    views_file,
    workspace_options,
)
from ballscrew.own_effect.composed_file import taken_in, write_composed
from ballscrew.own_effect.named import Named
from ballscrew.page.improvement_page import write_report
from ballscrew.report.felt_report import AtTheTable, at_the_table, felt_json, felt_section, felt_sentence
from ballscrew.report.improvement_report import (
    Outcome,
    as_json,
    before_and_after,
    print_steps,
    recordings_kept,
    steps_section,
    titles,
)  # fmt: skip
from ballscrew.report.use_report import print_use
from ballscrew.search import effects_to_try, verdict_of
from ballscrew.terminal import INTERRUPTED
from ballscrew.workers.processes import working
from ballscrew.workspace import Workspace, runs_of
from estimator.missing_effect.improve import Improvement, improve
from estimator.model import Model
from estimator.rig_folder.model_toml import save_model


@click.command("improve")
@search_options
@model_output("Write the best model here.")
@output_file(
    "--report", "md", metavar="OUT.md|.html",
    help="Write the report here, with its pictures beside it, or in it as HTML; default: beside MODEL.",
)  # fmt: skip
@views_file("Write the views, before and after, as a rerun file; default: beside MODEL.")
@view_option
@recording_workers
@workspace_options
def command(
    work: Workspace, held_out: tuple[Path, ...], own: tuple[str, ...], compose: Path | None, out: Path, md: Path | None,
    rrd: Path | None, view: bool, workers: int | str | None,
) -> int:  # fmt: skip
    """Add the effects that are missing from the model, one at a time, until none makes all LOGs clearly better.

    Each step is judged by recordings left out; one that foretells --held-out ones worse is told and not kept. Writes
    the model, a report with pictures, and views before and after. With --compose what no catalogue has is written down
    as an effect and added too, up to three of them. Ctrl-C ends the search; the best model so far is written.
    """
    effects = effects_to_try(work, own)
    taken = taken_in(compose) if compose is not None else None
    work.read_once(held_out)
    with work.runs("improving", processes=workers) as runs:
        kept_apart = runs_of(work.rig, work.held_out, runs.workers)
        improvement = improve(work.model, runs, kept_apart, [one.effect for one in effects], taken)
    if compose is not None:
        effects += write_composed(improvement.composed, compose)
    after = _kept(improvement, effects, work, out.name)
    save_model(after, out)
    print_use(work.terminal, improvement.uses, work.rig)
    print_steps(work.terminal, improvement, compose)
    if compose is not None and not improvement.composed:
        work.terminal.say(f"{compose}: nothing was composed, nothing is written")
    work.terminal.say(f"model: {out}")
    table = _felt(work, improvement, after, workers)
    work.terminal.json({**as_json(improvement, compose), "felt": felt_json(table), "model": str(out)})
    if improvement.last is None:
        work.terminal.say("stopped by Ctrl-C: the best so far was kept; no report")
        return INTERRUPTED
    md, rrd = md or out.with_suffix(".md"), rrd or out.with_suffix(".rrd")
    said = _drawn(work, improvement, after, table, own, md, rrd)
    work.terminal.say("\n" + "\n".join([said, *([felt_sentence(table)] if table else []), f"report: {md}"]))
    work.terminal.show_views(rrd, view)
    return work.status


def _kept(improvement: Improvement, effects: Sequence[Named], work: Workspace, name: str) -> Model:
    """The best model under its new name, with where its own effects came from and what it was fitted to."""
    best = replace(improvement.model, name=name)
    for one in effects:
        if one.effect.name in best.effects:
            best = one.used_by(best)
    if len(improvement.kept) == 1:
        return best
    fitted = dict(best.about.get("fitted_on", {}))
    for r in work.recordings:
        if r.fingerprint not in fitted.values() and r.name not in improvement.left_out:
            fitted[r.name if r.name not in fitted else f"{r.name} ({r.fingerprint})"] = r.fingerprint
    return replace(best, about={**best.about, "rig": work.rig.fingerprint(), "fitted_on": fitted})


def _felt(work: Workspace, improvement: Improvement, after: Model, processes: int | str | None) -> list[AtTheTable]:
    """What the filter leaves at the table before and after; nothing after Ctrl-C."""
    if improvement.last is None:
        return []
    several = processes or work.processes
    with work.terminal.progress("asking what the axis feels", None), working(several) as workers:
        runs = {
            name: runs_of(work.rig, some, workers)
            for name, some in (("used", work.loaded), ("held out", work.held_out))
        }
        return at_the_table(before_and_after(improvement, after), runs)


def _drawn(
    work: Workspace, improvement: Improvement, after: Model, table: Sequence[AtTheTable], own: Sequence[str], md: Path,
    rrd: Path,
) -> str:  # fmt: skip
    """Write the report and the views; the verdict in words."""
    from ballscrew.report import comparison_views as views  # rerun takes a while

    assert improvement.last is not None
    with work.terminal.progress("drawing before and after", None), working() as workers:
        searched = runs_of(work.rig, recordings_kept(improvement, work.loaded), workers)
        verdict = verdict_of(improvement.last, searched, runs_of(work.rig, []))
        out = Outcome(improvement, verdict, improvement.steps[0].model, after, table, work, own)
        runs = views.compared(work.rig, out.models, [*work.loaded, *work.held_out], workers)
        used = len(work.loaded)
        runs[used:] = [replace(run, name=f"{run.name} held out") for run in runs[used:]]
        steps = zip(titles(improvement.steps), improvement.steps, strict=True)
        figures = views.error_bars([(title, step.cross_validated, step.held_out) for title, step in steps])
        figures += [views.felt_bars(one) for one in table[-1:]]
        write_report(md, out, workers, lambda stem: views.write_pictures(stem, runs, out.models, figures))
        first_page = [steps_section(out), *([felt_section(table)] if table else [])]
        views.write_views(rrd, runs, out.models, first_page, figures)
    return out.said
