"""ballscrew improve: add to a model what is missing, effect by effect, as long as that helps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click

from ballscrew.commands.suggest import finding_of, fitting, search_options, wanted_effects
from ballscrew.options import logs_argument, output_options, rig_options, writable
from ballscrew.own_effect.named import Named
from ballscrew.report.improvement_report import Outcome, as_json, note, report, steps_section, steps_table, titles
from ballscrew.report.viewing import show, view_option
from ballscrew.terminal import INTERRUPTED, Terminal
from ballscrew.threads import threads
from ballscrew.workspace import Loaded, load_apart, open_model, open_rig, runs_of
from estimator.errors import InputError
from estimator.missing_effect.improve import Improvement, improve
from estimator.model import Model
from estimator.record import Recording
from estimator.rig import Rig
from estimator.rig_folder.model_toml import save_model


@click.command("improve")
@logs_argument
@rig_options
@search_options
@click.option(
    "-o", "out", type=click.Path(path_type=Path), required=True, callback=writable, metavar="MODEL",
    help="Write the best model here.",
)  # fmt: skip
@click.option(
    "--report", "md", type=click.Path(path_type=Path), callback=writable, metavar="OUT.md",
    help="Write the report here, with its pictures beside it; default: beside MODEL.",
)  # fmt: skip
@click.option(
    "--save", "rrd", type=click.Path(path_type=Path), callback=writable, metavar="OUT.rrd",
    help="Write the views, before and after, as a rerun file; default: beside MODEL.",
)  # fmt: skip
@view_option
@output_options
def command(
    logs: tuple[Path, ...], rig_path: Path | None, model_path: Path | None, held_out: tuple[Path, ...],
    own: tuple[str, ...], out: Path, md: Path | None, rrd: Path | None, view: bool, json_path: str | None, quiet: bool,
    debug: bool,
) -> int:  # fmt: skip
    """Add the effects that are missing from the model, one at a time, until none makes all LOGs clearly better.

    Each step is judged by recordings left out; --held-out ones are never looked at, only reported. Writes the model, a
    report with pictures, and views before and after. Ctrl-C ends the search; the best model so far is written.
    """
    terminal = Terminal(json_path, quiet)
    rig = open_rig(logs, rig_path, terminal)
    model = open_model(rig, model_path, terminal)
    fitting(terminal, model, rig, effects := wanted_effects(model, own))
    loaded, apart, failed = load_apart(logs, held_out, rig, terminal)
    if not loaded:
        return InputError.exit_code
    found = _searched(terminal, model, rig, loaded, apart, effects)
    after = _kept(found, effects, rig, [one.recording for one in loaded], out.name)
    save_model(after, out)
    _print(terminal, found, out)
    if found.last is None:
        terminal.say("stopped by Ctrl-C: the best so far was kept; no report")
        return INTERRUPTED
    rrd = rrd or out.with_suffix(".rrd")
    _tell(terminal, found, after, rig, loaded, apart, own, md or out.with_suffix(".md"), rrd)
    show(terminal, rrd, view)
    return InputError.exit_code if failed else 0


def _print(terminal: Terminal, found: Improvement, out: Path) -> None:
    head, *rows = steps_table(found.steps)
    terminal.table("", head, rows, prose=len(head) - 1)
    terminal.say(f"({note(found)})")
    terminal.say(f"model: {out}")
    terminal.json({**as_json(found), "model": str(out)})


def _searched(
    terminal: Terminal, model: Model, rig: Rig, loaded: Sequence[Loaded], apart: Sequence[Loaded],
    effects: Sequence[Named],
) -> Improvement:  # fmt: skip
    with terminal.progress("improving", 1.0) as update, threads() as workers:
        runs, held_out = runs_of(rig, loaded, workers, update), runs_of(rig, apart, workers)
        return improve(model, runs, held_out, [one.effect for one in effects])


def _kept(found: Improvement, effects: Sequence[Named], rig: Rig, recordings: Sequence[Recording], name: str) -> Model:
    """The best model under its new name, with where its own effects came from and what it was fitted to."""
    best = replace(found.model, name=name)
    for one in effects:
        if one.effect.name in best.effects:
            best = one.used_by(best)
    if len(found.steps) == 1:
        return best
    fitted = dict(best.about.get("fitted_on", {}))
    for r in recordings:
        if r.fingerprint not in fitted.values():
            fitted[r.name if r.name not in fitted else f"{r.name} ({r.fingerprint})"] = r.fingerprint
    return replace(best, about={**best.about, "rig": rig.fingerprint(), "fitted_on": fitted})


def _tell(
    terminal: Terminal, found: Improvement, after: Model, rig: Rig, loaded: Sequence[Loaded], apart: Sequence[Loaded],
    own: Sequence[str], md: Path, rrd: Path,
) -> None:  # fmt: skip
    """The verdict, the report and the views."""
    from ballscrew.report.comparison_views import (  # rerun takes a while
        compared,
        error_bars,
        write_pictures,
        write_views,
    )

    assert found.last is not None
    with terminal.progress("drawing before and after", None), threads() as workers:
        verdict = finding_of(found.last, runs_of(rig, loaded, workers), runs_of(rig, []))
        out = Outcome(found, verdict, found.steps[0].model, after, rig, loaded, apart, own)
        runs = compared(rig, out.models, [*loaded, *apart], workers)
        runs[len(loaded) :] = [replace(run, name=f"{run.name} held out") for run in runs[len(loaded) :]]
        steps = zip(titles(found.steps), found.steps, strict=True)
        figures = error_bars([(title, step.cross_validated, step.held_out) for title, step in steps])
        pictures = write_pictures(md.with_suffix(""), runs, out.models, figures)
        md.write_text(report(out, pictures, workers))
        write_views(rrd, runs, out.models, [steps_section(out)], figures)
    terminal.say(f"\n{out.said}")
    terminal.say(f"report: {md}")
