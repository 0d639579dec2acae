"""ballscrew fit: fit a model's parameters to recordings."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from ballscrew.options import logs_argument, output_options, rig_options, writable
from ballscrew.terminal import INTERRUPTED, Terminal
from ballscrew.threads import threads
from ballscrew.workspace import load, open_model, open_rig, runs_of
from estimator.accuracy.floor import Error
from estimator.errors import InputError
from estimator.fit.fit import Fit, Fitted, fit
from estimator.rig_folder.model_toml import save_model

HORIZONS = {"one_step": "one tick ahead", "ahead": "10 minutes ahead", "open_loop": "model alone (open loop)"}
WORSE = 1.2  # times an error before
WORTH_SAYING = 1.005  # factors of the process noise
KEPT = {
    "likelihood": "kept: the most likely parameters",
    "open loop": "kept: the parameters with which the model alone follows best; the most likely ones predict worse",
}


@click.command("fit")
@logs_argument
@rig_options
@click.option(
    "-o",
    "out",
    type=click.Path(path_type=Path),
    required=True,
    callback=writable,
    metavar="MODEL",
    help="Write the model here.",
)
@output_options
def command(
    logs: tuple[Path, ...], rig_path: Path | None, model_path: Path | None, out: Path, json_path: str | None,
    quiet: bool, debug: bool,
) -> int:  # fmt: skip
    """Fit the free parameters of the model to all LOGs at once.

    First so that the model alone follows the measurements (least squares, open loop), then by maximum likelihood; what
    predicts better ten minutes ahead is kept. A truth file is never opened. Parameters marked fixed in the model file
    stay, and so do those that these recordings cannot tell from others. Ctrl-C ends the search; the best model so far
    is written, if there is one.
    """
    terminal = Terminal(json_path, quiet)
    rig = open_rig(logs, rig_path, terminal)
    model = open_model(rig, model_path, terminal)
    loaded, failed = load(logs, rig, terminal)
    if not loaded:
        return InputError.exit_code
    terminal.say_if_compiling("passes", "loglike", "score", "gram", "ahead")
    label = f"fitting {len(model.free())} parameters to {len(loaded)} recordings"
    with terminal.progress(label, None) as update, threads() as workers:
        found = fit(model, runs_of(rig, loaded, workers, update))
    save_model(found.model, out)
    _print(terminal, found)
    terminal.say(f"model: {out}")
    terminal.json(_as_json(found))
    if found.stopped:
        return INTERRUPTED
    return InputError.exit_code if failed else 0


def _print(terminal: Terminal, found: Fit) -> None:
    rows = [
        [
            f.path,
            f"{f.before:.4g}",
            f"{f.value:.4g}",
            f"{f.sd:.2g}" if np.isfinite(f.sd) else "",
            f.unit,
            _remark(found, f),
        ]
        for f in found.parameters
    ]
    terminal.table("", ["parameter", "before", "fitted", "+- sd", "unit", ""], rows, prose=5)
    terminal.say()
    terminal.table("", ["error, rms", "before", "after", "", "before", "after", ""], _errors(found))
    terminal.say(KEPT[found.kept])
    for sentence in worse(found):
        terminal.say(sentence)
    for a, b, rho in found.alike:
        terminal.say(f"{a} and {b} cannot be told apart well: their errors correlate by {rho:+.3f}")
    if found.raised >= WORTH_SAYING:
        terminal.say(f"process noise x {found.raised:.2f}: ten minutes without readings ended further off than it said")
    if found.stopped:
        terminal.say(f"stopped by Ctrl-C after {found.steps} steps: the best so far was kept")
    elif not found.converged:
        terminal.say(f"not converged after {found.steps} steps: the best so far was kept; fit again from it")


def worse(found: Fit) -> list[str]:
    """Said where the fitted model predicts the elongation of these very recordings worse than the one it came from."""
    return [
        f"the elongation became worse, {HORIZONS[key]} {found.before[key].elongation_um:.2f} -> "
        f"{found.after[key].elongation_um:.2f} um, for the temperatures' sake: compare both on other recordings first"
        for key in ("ahead", "open_loop")
        if found.after[key].elongation_um > WORSE * found.before[key].elongation_um
    ]


def _errors(found: Fit) -> list[list[str]]:
    return [[title, *_pair(found.before[key], found.after[key])] for key, title in HORIZONS.items()]


def _pair(a: Error, b: Error) -> list[str]:
    kelvin = [f"{a.temperature_K:.3f}", f"{b.temperature_K:.3f}", "K"]
    lengths = [f"{a.elongation_um:.2f}", f"{b.elongation_um:.2f}", "um"]
    none = ["", "", ""]  # a run may be too short to look ahead, or have no length
    return [
        *(kelvin if np.isfinite(b.temperature_K) else none),
        *(lengths if np.isfinite(b.elongation_um) else none),
    ]


def _remark(found: Fit, f: Fitted) -> str:
    if f.like:
        return f"left as it was: in these runs like {f.like}"
    if not np.isfinite(f.sd):
        return "left as it was: without influence in these runs"
    if f.at_bound:
        return "at its bound"
    if f.determined:
        return ""
    return "these runs say less than the table" if found.model.param(f.path).sd else "these runs do not determine it"


def _as_json(found: Fit) -> dict[str, object]:
    parameters = {
        f.path: {
            "before": f.before, "value": f.value, "sd": f.sd, "unit": f.unit, "at_bound": f.at_bound,
            "determined": f.determined, "like": f.like or None,
        }
        for f in found.parameters
    }  # fmt: skip
    errors = {key: {"before": _error(found.before[key]), "after": _error(found.after[key])} for key in HORIZONS}
    return {
        "parameters": parameters, **errors, "kept": found.kept, "process_noise_raised": found.raised,
        "correlated": [{"parameters": [a, b], "correlation": rho} for a, b, rho in found.alike],
        "log_likelihood": {"open_loop": found.loglike[0], "best": found.loglike[1]},
        "converged": found.converged, "stopped": found.stopped, "steps": found.steps,
    }  # fmt: skip


def _error(error: Error) -> dict[str, float]:
    return {"temperature_K": error.temperature_K, "elongation_um": error.elongation_um}
