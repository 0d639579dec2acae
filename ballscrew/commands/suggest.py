"""ballscrew suggest: say which physical effect is missing from a model."""

import shlex
from dataclasses import replace
from pathlib import Path

import click

from ballscrew.options import PATH, recording_workers, save_option, search_options, workspace_options
from ballscrew.own_effect.composed_file import taken_in, write_composed
from ballscrew.own_effect.named import Named
from ballscrew.report.search.search_report import as_json, print_verdict, ranked, section_of
from ballscrew.report.use_report import print_use
from ballscrew.search import Verdict, effects_to_try, verdict_of
from ballscrew.workspace import Workspace, runs_of
from estimator.missing_effect.suggest import suggest
from estimator.missing_effect.suggestion import Suggestion


@click.command("suggest")
@search_options
@click.option(
    "--healthy", multiple=True, type=PATH, metavar="LOG",
    help="A recording, or folder of them, of the same machine when nothing was missing: the model is fitted to these "
    "first, and the question is what has changed since; may be repeated.",
)  # fmt: skip
@save_option
@recording_workers
@workspace_options
def command(
    work: Workspace, held_out: tuple[Path, ...], own: tuple[str, ...], compose: Path | None, healthy: tuple[Path, ...],
    rrd: Path | None, workers: int | str | None,
) -> int:  # fmt: skip
    """Say which effect is missing from the model, as judged by all LOGs: each is left out once.

    The verdict is an effect; a tie, with the run that would decide; a wrong input of one recording; nothing in the
    catalogue, with the place, what it follows, and an effect composed of these; or nothing missing. A truth file is
    never opened. The views show the model, and beside it the one with the best effect.
    """
    effects = [one.effect for one in effects_to_try(work, own)]
    taken = taken_in(compose) if compose is not None else []
    work.read_once(held_out)
    before = work.read_besides(healthy) if healthy else []
    with work.runs("looking for what is missing", processes=workers) as runs:
        known = runs_of(work.rig, before, runs.workers) if before else None
        found = suggest(work.model, runs, effects, healthy=known, taken=taken)
        verdict = verdict_of(found, runs, runs_of(work.rig, work.held_out, runs.workers))
    print_use(work.terminal, verdict.uses, work.rig)
    print_verdict(work.terminal, verdict, work.rig)
    written = _written(found, compose)
    for one in written:
        work.terminal.say(f"{one.file}: {one.effect.__name__} written; next: {_check(one, work)}")
    if compose is not None and not written:
        work.terminal.say(f"{compose}: nothing was composed, nothing is written")
    work.terminal.json(as_json(verdict, work.rig, compose if written else None))
    if rrd is not None:
        _save(rrd, work, verdict)
    return work.status


def _written(found: Suggestion, file: Path | None) -> list[Named]:
    """The composed effect in its file, where there is one and that was asked for."""
    return write_composed([found.composed], file) if file is not None and found.composed is not None else []


def _check(one: Named, work: Workspace) -> str:
    """The command that checks it on this rig and model, which need not be those nearest to the file."""
    words, rig, model = ["ballscrew", "effects", one.use, "--check"], work.rig.folder, work.model
    assert one.file is not None
    if work.rig_path or rig.resolve() not in one.file.resolve().parents:
        words += ["--rig", str(work.rig_path or rig)]
    path = (model.folder or Path()) / model.name
    return shlex.join([*words, *(["--model", str(path)] if path.resolve() != (rig / "model.toml").resolve() else [])])


def _save(path: Path, work: Workspace, verdict: Verdict) -> None:
    from ballscrew.report.comparison_views import error_bars, save_views  # rerun takes half a second to import

    suggestion = verdict.suggestion
    best = [suggestion.composed.hypothesis] if suggestion.composed is not None else suggestion.found[:1]
    models = [work.model, *(replace(h.model, name=f"with {h.names[0]}") for h in best)]
    figures = error_bars([(title, h.judged.error, held) for title, h, held in ranked(verdict)])
    save_views(path, work, models, [section_of(verdict, work.rig)], figures)
