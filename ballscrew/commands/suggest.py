"""ballscrew suggest: say which physical effect is missing from a model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from ballscrew.options import logs_argument, output_options, rig_options, save_option
from ballscrew.own_effect.named import Named, named_effects
from ballscrew.report.verdict import Finding, as_json, sentence
from ballscrew.terminal import Terminal
from ballscrew.threads import threads
from ballscrew.workspace import Loaded, load_apart, open_model, open_rig, runs_of
from estimator.accuracy.floor import Error
from estimator.accuracy.horizon import open_loop_error
from estimator.batch.trials import slow_trials_of
from estimator.effects import CATALOGUE
from estimator.errors import InputError
from estimator.missing_effect.candidates import unfit
from estimator.missing_effect.hypothesis import Hypothesis
from estimator.missing_effect.next_run import next_run
from estimator.missing_effect.suggest import suggest
from estimator.missing_effect.suggestion import Suggestion
from estimator.model import Model
from estimator.rig import Rig
from estimator.work import Runs

SHOWN = 6


def search_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """--held-out and --effects, the same on every command that searches."""
    held = click.option(
        "--held-out", "held_out", multiple=True, type=click.Path(path_type=Path), metavar="LOG",
        help="A recording, or folder of them, that is never used to choose or fit, only reported; may be repeated.",
    )  # fmt: skip
    own = click.option(
        "--effects", "own", multiple=True, metavar="FILE.py[:Class]",
        help="Effects of your own to try as well. The file is Python, and runs.",
    )  # fmt: skip
    return held(own(command))


def wanted_effects(model: Model, own: Sequence[str]) -> list[Named]:
    """The catalogue, the effects named on the command line, and those beside the ones that the model uses."""
    files = [str((model.folder or Path()) / use.partition(":")[0]) for use in model.use.values()]
    mine = {one.effect.name: one for word in dict.fromkeys([*files, *own]) for one in named_effects(word)}
    return [*(Named(effect) for name, effect in CATALOGUE.items() if name not in mine), *mine.values()]


def fitting(terminal: Terminal, model: Model, rig: Rig, effects: Sequence[Named]) -> None:
    """Say which effects of one's own cannot be tried on this rig, and why."""
    for one in effects:
        if one.file is not None and one.effect.name not in model.effects and (why := unfit(model, rig, one.effect)):
            terminal.warn(f"{one.use} is not tried: {why}")


@click.command("suggest")
@logs_argument
@rig_options
@search_options
@save_option
@output_options
def command(
    logs: tuple[Path, ...], rig_path: Path | None, model_path: Path | None, held_out: tuple[Path, ...],
    own: tuple[str, ...], rrd: Path | None, json_path: str | None, quiet: bool, debug: bool,
) -> int:  # fmt: skip
    """Say which effect is missing from the model, as judged by all LOGs: each is left out once.

    The verdict is an effect; a tie, with the run that would decide; a wrong input of one recording; nothing in the
    catalogue, with the place and what it follows; or nothing missing. A truth file is never opened. The views show the
    model, and beside it the one with the best effect.
    """
    terminal = Terminal(json_path, quiet)
    rig = open_rig(logs, rig_path, terminal)
    model = open_model(rig, model_path, terminal)
    fitting(terminal, model, rig, wanted := wanted_effects(model, own))
    effects = [one.effect for one in wanted]
    loaded, apart, failed = load_apart(logs, held_out, rig, terminal)
    if not loaded:
        return InputError.exit_code
    with terminal.progress("looking for what is missing", 1.0) as update, threads() as workers:
        runs = runs_of(rig, loaded, workers, update)
        found = finding_of(suggest(model, runs, effects), runs, runs_of(rig, apart, workers))
    print_finding(terminal, found, rig)
    terminal.json(as_json(found, rig))
    if rrd is not None:
        _save(terminal, rrd, rig, model, loaded, found)
    return InputError.exit_code if failed else 0


def finding_of(found: Suggestion, runs: Runs, held_out: Runs) -> Finding:
    """What was found, with the run that decides a tie and the recordings held out."""
    run = None
    if found.verdict == "tie" and len(found.tie) > 1:
        runs.progress("looking for the run that decides", 0.95)
        rivals = [h for h in found.found if h.names[0] in found.tie][:2]
        if len(rivals) == 2:
            run = next_run(rivals[0], rivals[1], runs)
    models = [h.model for h in (found.as_given, found.again, *found.found)] if held_out.recordings else []
    return Finding(found, [open_loop_error(slow_trials_of(model, held_out), model) for model in models], run)


def print_finding(terminal: Terminal, found: Finding, rig: Rig) -> None:
    """The ranking as a table, and the verdict."""
    head, *rows = ranking(found)
    terminal.table("", head, rows, prose=len(head) - 1)
    terminal.say(f"({_note(found)})")
    terminal.say()
    terminal.say(sentence(found, rig))


def ranking(found: Finding) -> list[list[str]]:
    """The table of hypotheses, its head first."""
    head = ["open loop, rms", "K", "um", *(["held out, K", "um"] if found.held_out else []), "fitted", "value"]
    rows = [_row(*each) for each in _ranked(found)]
    return [head, *([*row, *[""] * (len(head) - len(row))] for row in rows)]


def _ranked(found: Finding) -> list[tuple[str, Hypothesis, Error | None]]:
    """Hypotheses with their title and error held out: the model, fitted again, and the best effects."""
    suggestion = found.suggestion
    ranked = [("the model as given", suggestion.as_given), ("all parameters fitted again", suggestion.again)]
    for h in suggestion.found[:SHOWN]:
        there = h.names[0] in suggestion.as_given.model.effects
        ranked.append((f"{h.names[0]} fitted again" if there else f"+ {h.names[0]}", h))
    held = [*found.held_out] or [None] * len(ranked)
    return [(*each, error) for each, error in zip(ranked, held, strict=False)]


def _note(found: Finding) -> str:
    once = "one recording: none left out" if found.suggestion.one_recording else "each recording left out once"
    return f"{once}; {'held out: never looked at; ' if found.held_out else ''}best first"


def _save(terminal: Terminal, path: Path, rig: Rig, model: Model, loaded: Sequence[Loaded], found: Finding) -> None:
    from ballscrew.report.comparison_views import error_bars, save_views  # rerun takes half a second to import

    best = [replace(h.model, name=f"with {h.names[0]}") for h in found.suggestion.found[:1]]
    section = "What is missing", [sentence(found, rig), _note(found)], ranking(found)
    figures = error_bars([(title, error_of(h), held) for title, h, held in _ranked(found)])
    save_views(terminal, path, rig, [model, *best], loaded, [section], figures)


def error_of(h: Hypothesis) -> Error:
    """Open-loop error on recordings left out."""
    return Error(h.judged.heat_K, h.judged.length_um)


def _row(title: str, h: Hypothesis, held: Error | None) -> list[str]:
    cells = [title, *_pair(error_of(h))]
    if held is not None:
        cells += _pair(held)
    own = {path: value for path, value in h.parameters().items() if path.partition(".")[0] in h.names}
    values = ", ".join(
        f"{path.partition('.')[2]} {value.value:.3g} +- {value.sd:.1g} {h.model.param(path).unit}"
        for path, value in own.items()
    )
    return [*cells, "all" if h.refit else "it alone" if h.names else "", values]


def _pair(error: Error) -> list[str]:
    return [f"{error.temperature_K:.3f}", f"{error.elongation_um:.2f}" if np.isfinite(error.elongation_um) else ""]
