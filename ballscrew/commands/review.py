"""ballscrew review: run the filter over recordings and say how good the estimate is."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

import click

from ballscrew.muting import chosen_thermometers, muted
from ballscrew.options import logs_argument, output_options, rig_options, save_option
from ballscrew.report.report import as_json, markdown, print_reviews
from ballscrew.report.viewing import show, view_option
from ballscrew.terminal import Terminal
from ballscrew.workspace import Loaded, load, open_model, open_rig, true_elongation
from estimator.accuracy.review import Review, review
from estimator.errors import InputError
from estimator.rig import Rig
from viz.recorded.run import Run, first_stop_s


@click.command("review")
@logs_argument
@rig_options
@click.option("--join", is_flag=True, help="The LOGs are parts of one recording: one estimate runs through them.")
@click.option("--channels", metavar="2,4,..", help="Use only these thermometers, by number or name; default: all.")
@click.option("--no-displacement", is_flag=True, help="Do not use the displacement readings.")
@click.option(
    "--mute", "spans", multiple=True, metavar="NAME:FROM[-TO]",
    help="Do not use a channel, `telemeter` or `displacement` from FROM to TO: seconds from the start, or stop1 ...",
)  # fmt: skip
@save_option
@view_option
@output_options
def command(
    logs: tuple[Path, ...], rig_path: Path | None, model_path: Path | None, join: bool, channels: str | None,
    no_displacement: bool, spans: tuple[str, ...], rrd: Path | None, view: bool, json_path: str | None, quiet: bool,
    debug: bool,
) -> int:  # fmt: skip
    """Run the Kalman filter over each LOG and print how far its elongation is from the reference.

    Beside it: the model alone, the polyline through the thermometers, and two estimates that need no model. The
    reference is the truth where a NAME.truth.csv lies beside the log, else the displacement readings. A folder means
    all recordings in it.
    """
    terminal = Terminal(json_path, quiet)
    rig = open_rig(logs, rig_path, terminal)
    model = open_model(rig, model_path, terminal)
    names = chosen_thermometers(channels, rig)
    loaded, failed = load(logs, rig, terminal, join)
    if not loaded:
        return InputError.exit_code
    terminal.say_if_compiling("passes")
    judged: list[Loaded] = []
    reviews, seconds = [], []
    for one in loaded:
        began = time.perf_counter()
        mute = muted(one.recording, rig, names, no_displacement, spans)
        truth = true_elongation(one, terminal, failed)
        try:
            with terminal.progress(one.recording.name, len(one.recording)) as update:
                reviews.append(review(one.recording, rig, model, truth, mute, names, update))
        except InputError as error:
            terminal.error(str(error))
            failed.append(str(error))
            continue
        judged.append(one)
        seconds.append(time.perf_counter() - began)
    if not reviews:
        return InputError.exit_code
    known = set(model.about.get("fitted_on", {}).values())
    fitted = [r.recording.fingerprint in known for r in reviews]
    print_reviews(terminal, reviews, fitted)
    terminal.json(as_json(reviews, fitted, seconds))
    if rrd is not None:
        _save(terminal, rrd, _runs(rig, judged, reviews), markdown(reviews), view)
    return InputError.exit_code if failed else 0


def _runs(rig: Rig, loaded: Sequence[Loaded], reviews: Sequence[Review]) -> list[Run]:
    return [
        Run(
            name=one.path.stem,
            rig=rig,
            recording=r.recording,
            track=r.track,
            smoothed_um=r.estimates["smoothed"],
            smoothed_sd_um=r.smoothed_sd,
            polyline_um=r.estimates["polyline"],
            readings_um=r.readings,
            reference_um=r.reference,
            reference_name=r.reference_name,
            errors_um=r.errors,
            error_sd_um=r.sigma["filter"],
            truth_C_rise=one.truth.rises(rig.thermometers, r.recording.time_s) if one.truth else None,
        )
        for one, r in zip(loaded, reviews, strict=True)
    ]


def _save(terminal: Terminal, path: Path, runs: Sequence[Run], summary: str, view: bool) -> None:
    from viz.recorded.recorded import save  # rerun takes half a second to import

    with terminal.progress(f"writing {path}", len(runs)) as update:
        save(path, runs, summary, update)
    show(terminal, path, view, first_stop_s(runs[0]))
