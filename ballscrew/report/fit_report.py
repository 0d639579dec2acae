"""A fit: tables, sentences and JSON."""

from collections.abc import Mapping

import numpy as np

from ballscrew.report.sections import HORIZONS, cells
from ballscrew.report.use_report import recordings_json
from ballscrew.terminal import Terminal
from estimator.fit.fit import Fit, Fitted

WORSE = 1.2  # times an error before
WORTH_SAYING = 1.005  # factors of the process noise


def print_fit(terminal: Terminal, fit: Fit) -> None:
    """Parameters and errors, before and after, and what a person should know of the outcome."""
    rows = [_row(fit, f) for f in fit.parameters]
    terminal.table([["parameter", "before", "fitted", "+- sd", "unit", ""], *rows], prose=5)
    terminal.say()
    errors = [[title, *cells([fit.before[key], fit.after[key]])] for key, title in HORIZONS.items()]
    terminal.table([["error, rms", "before, K", "um", "after, K", "um"], *errors])
    for sentence in (*worse(fit), *_cautions(fit)):
        terminal.say(sentence)


def _row(fit: Fit, f: Fitted) -> list[str]:
    sd = f"{f.sd:.2g}" if np.isfinite(f.sd) else ""
    return [f.path, f"{f.before:.4g}", f"{f.value:.4g}", sd, f.unit, _remark(fit, f)]


def _remark(fit: Fit, f: Fitted) -> str:
    if f.like:
        return f"left as it was: in these runs like {f.like}"
    if not np.isfinite(f.sd):
        return "left as it was: without influence in these runs"
    if f.at_bound:
        return "at its bound"
    if f.determined:
        return ""
    return "these runs say less than the table" if fit.model.param(f.path).sd else "these runs do not determine it"


def worse(fit: Fit) -> list[str]:
    """Said where the fitted model predicts the elongation of these very recordings worse than the one it came from."""
    return [
        f"the elongation became worse, {HORIZONS[key]} {before:.2f} -> {after:.2f} um, for the temperatures' sake: "
        "compare both on other recordings first"
        for key in ("ahead", "open_loop")
        if (after := fit.after[key].elongation_um) > WORSE * (before := fit.before[key].elongation_um)
    ]


def _cautions(fit: Fit) -> list[str]:
    said = [f"{a} and {b} cannot be told apart well: their errors correlate by {rho:+.3f}" for a, b, rho in fit.alike]
    if fit.scatter > 1.0:
        said.append(f"thermometers' noise x {fit.scatter:.2f}: successive readings differ by more than it said")
    if fit.raised.others >= WORTH_SAYING:
        said.append(
            f"process noise x {fit.raised.others:.2f}: ten minutes without readings ended further off than it said"
        )
    if fit.raised.places >= WORTH_SAYING:
        said.append(
            f"the screw's own process noise x {fit.raised.places:.2f}: thermometers that the filter does not see are "
            "further off than it said"
        )
    if fit.stopped:
        said.append(f"stopped by Ctrl-C after {fit.steps} runs: the best so far was kept")
    elif not fit.converged:
        said.append(f"not converged after {fit.steps} runs: the best so far was kept; fit again from it")
    return said


def as_json(fit: Fit) -> dict[str, object]:
    """The fit for programs."""
    keys = ("before", "value", "sd", "unit", "at_bound", "determined")
    parameters = {f.path: {**{key: getattr(f, key) for key in keys}, "like": f.like or None} for f in fit.parameters}
    errors: Mapping[str, object] = {
        key: {"before": vars(fit.before[key]), "after": vars(fit.after[key])} for key in HORIZONS
    }
    return {
        "recordings": recordings_json(fit.uses),
        "parameters": parameters, **errors, "process_noise_raised": vars(fit.raised),
        "thermometer_noise_raised": fit.scatter,
        "correlated": [{"parameters": [a, b], "correlation": rho} for a, b, rho in fit.alike],
        "converged": fit.converged, "stopped": fit.stopped, "steps": fit.steps,
    }  # fmt: skip
