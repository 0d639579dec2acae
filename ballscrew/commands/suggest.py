"""ballscrew suggest: say which physical effect is missing from a model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from ballscrew.options import logs_argument, rig_options, save_option, search_options, terminal_options
from ballscrew.report.search_report import as_json, error_of, print_verdict, ranked, section_of
from ballscrew.search import Verdict, effects_to_try, verdict_of
from ballscrew.terminal import Terminal
from ballscrew.workspace import Workspace, open_workspace, runs_of
from estimator.missing_effect.suggest import suggest


@click.command("suggest")
@logs_argument
@rig_options
@search_options
@save_option
@terminal_options
def command(
    terminal: Terminal, logs: tuple[Path, ...], rig_path: Path | None, model_path: Path | None,
    held_out: tuple[Path, ...], own: tuple[str, ...], rrd: Path | None,
) -> int:  # fmt: skip
    """Say which effect is missing from the model, as judged by all LOGs: each is left out once.

    The verdict is an effect; a tie, with the run that would decide; a wrong input of one recording; nothing in the
    catalogue, with the place and what it follows; or nothing missing. A truth file is never opened. The views show the
    model, and beside it the one with the best effect.
    """
    work = open_workspace(terminal, logs, rig_path, model_path)
    effects = [one.effect for one in effects_to_try(work, own)]
    work.read(logs, held_out)
    with work.runs("looking for what is missing") as runs:
        found = verdict_of(suggest(work.model, runs, effects), runs, runs_of(work.rig, work.held_out, runs.workers))
    print_verdict(terminal, found, work.rig)
    terminal.json(as_json(found, work.rig))
    if rrd is not None:
        _save(rrd, work, found)
    return work.status


def _save(path: Path, work: Workspace, found: Verdict) -> None:
    from ballscrew.report.comparison_views import error_bars, save_views  # rerun takes half a second to import

    best = [replace(h.model, name=f"with {h.names[0]}") for h in found.suggestion.found[:1]]
    figures = error_bars([(title, error_of(h), held) for title, h, held in ranked(found)])
    save_views(path, work, [work.model, *best], [section_of(found, work.rig)], figures)
