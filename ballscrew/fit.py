"""ballscrew fit: fit a model's parameters to recordings."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from ballscrew.options import logs_argument, output_options, rig_options, writable
from ballscrew.terminal import Terminal
from ballscrew.workspace import load, open_model, open_rig
from estimator.errors import InputError
from estimator.fit import Fit, Fitted, fit
from estimator.model import Model, save_model


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
    """Fit the free parameters of the model to all LOGs at once, so that the model alone follows the measurements.

    The model runs open loop from each log's first sample: no measurement after it helps, so that what is missing shows.
    A truth file is never opened. Parameters marked fixed in the model file stay.
    """
    terminal = Terminal(json_path, quiet)
    rig = open_rig(logs, rig_path, terminal)
    model = open_model(rig, model_path, terminal)
    loaded, failed = load(logs, rig, terminal)
    if not loaded:
        return InputError.exit_code
    with terminal.progress(f"fitting {len(model.free())} parameters to {len(loaded)} recordings", None) as update:
        found = fit(
            model, rig, [one.recording for one in loaded], lambda n, misfit: update(n, f"run {n}: {misfit:.3f}")
        )
    save_model(found.model, out)
    _print(terminal, found)
    _print_doubt(terminal, model, found.model)
    terminal.say(f"model: {out}")
    terminal.json(_as_json(found))
    return InputError.exit_code if failed else 0


def _print(terminal: Terminal, found: Fit) -> None:
    rows = [
        [f.path, f"{f.before:.4g}", f"{f.value:.4g}", f"{f.sd:.2g}" if np.isfinite(f.sd) else "", f.unit, _remark(f)]
        for f in found.parameters
    ]
    terminal.table("", ["parameter", "before", "fitted", "+- sd", "unit", ""], rows)
    (k0, um0), (k1, um1) = found.before, found.after
    lengths = f", displacement {um0:.2f} -> {um1:.2f} um" if np.isfinite(um1) else ""
    terminal.say(f"open-loop misfit, rms: thermometers {k0:.3f} -> {k1:.3f} K{lengths}")
    if not found.converged:
        terminal.say(f"not converged after {found.evaluations} runs: the best so far was kept; fit again from it")


def _print_doubt(terminal: Terminal, before: Model, after: Model) -> None:
    """Say when the fit took the filter's trust in the model down to what the misfit allows."""
    if "conduction.noise" in after.values and after["conduction.noise"] > before["conduction.noise"]:
        was, now = before["conduction.noise"], after["conduction.noise"]
        terminal.say(
            f"unmodelled heat raised from {was:.3g} to {now:.3g} W/sqrt(Hz m): the misfit is larger than assumed"
        )


def _remark(f: Fitted) -> str:
    if not np.isfinite(f.sd):
        return "without influence"
    return "at its bound" if f.at_bound else ""


def _as_json(found: Fit) -> dict[str, object]:
    parameters = {
        f.path: {"before": f.before, "value": f.value, "sd": f.sd, "unit": f.unit, "at_bound": f.at_bound}
        for f in found.parameters
    }
    before, after = ({"temperature_K": k, "elongation_um": um} for k, um in (found.before, found.after))
    return {
        "parameters": parameters, "open_loop": {"before": before, "after": after},
        "converged": found.converged, "runs": found.evaluations,
    }  # fmt: skip
