"""ballscrew compare: models against recordings, beside each other."""

from pathlib import Path

import click

from ballscrew.machine import MachineVerdict
from ballscrew.options import NEAREST_RIG, PATH, logs_argument, rig_option, save_option, terminal_options
from ballscrew.report.comparison_report import as_json, sections
from ballscrew.report.sections import print_sections
from ballscrew.report.use_report import print_use
from ballscrew.terminal import Terminal
from ballscrew.workspace import open_model, open_workspace
from estimator.accuracy.compare import compare


@click.command("compare")
@logs_argument
@rig_option(f"Rig folder; {NEAREST_RIG}")
@click.option(
    "--model", "model_paths", type=PATH, multiple=True,
    help="Model TOML, once for each model to compare; else the rig folder's model.toml.",
)  # fmt: skip
@save_option
@terminal_options
def command(
    terminal: Terminal, logs: tuple[Path, ...], rig_path: Path | None, model_paths: tuple[Path, ...], rrd: Path | None
) -> int:
    """Print how far one or more models are from the readings in all LOGs: where, when, and how far ahead.

    The elongation is compared with the truth where a NAME.truth.csv lies beside the log, else with the readings. One
    tick ahead, ten minutes ahead, and by the model alone from the first sample on; by channel, by phase and by
    speed, with what the sensors alone would leave beside it. The views show one model, or two: before and after.
    """
    if rrd is not None and len(model_paths) > 2:
        raise click.UsageError("--save shows one model, or two beside each other")
    first, *others = model_paths or (None,)
    work = open_workspace(terminal, logs, rig_path, first)
    models = [work.model, *(open_model(work.rig, path, terminal) for path in others)]
    work.read()
    work.part()
    terminal.say_if_compiling("passes", "ahead")
    truths, comparisons = [work.truth_of(one) for one in work.loaded], []
    with work.runs("comparing", len(models)) as runs:
        for done, model in enumerate(models):
            runs.progress(model.name, done)
            comparisons.append(compare(model, runs, truths))
    pairs = list(zip(comparisons, models, strict=True))
    verdicts = [MachineVerdict(work, model, one.match, work.loaded) for one, model in pairs]
    print_sections(terminal, tables := sections(comparisons, [v.sentence for v in verdicts if v.sentence]))
    print_use(terminal, comparisons[0].uses, work.rig)
    told = [as_json(one) | {"machine": verdict.as_json()} for one, verdict in zip(comparisons, verdicts, strict=True)]
    terminal.json({"models": told})
    if rrd is not None:
        from ballscrew.report.comparison_views import save_views  # rerun takes half a second to import

        save_views(rrd, work, models, tables)
    return work.status
