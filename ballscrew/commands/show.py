"""ballscrew show: a model as equations with values, units, bounds and sources."""

from __future__ import annotations

from pathlib import Path

import click

from ballscrew.options import PATH, terminal_options
from ballscrew.report.page import print_effect
from ballscrew.terminal import Terminal
from estimator.effect import Param
from estimator.model import Model, Value
from estimator.rig_folder.model_toml import load_model


@click.command("show")
@click.argument("model", type=PATH, metavar="MODEL")
@terminal_options
def command(terminal: Terminal, model: Path) -> None:
    """Print MODEL: one paragraph for each effect, with its equation and a table of its parameters."""
    found = load_model(model)
    terminal.say(f"{model}: {len(found.effects)} effects, {len(found.free())} free parameters")
    if found.about.get("fitted_on"):
        terminal.say("fitted on " + ", ".join(found.about["fitted_on"]))
    for name, effect in found.effects.items():
        terminal.say()
        print_effect(terminal, effect)
        rows = [_row(key, param, found.values[f"{name}.{key}"]) for key, param in effect.params.items()]
        terminal.table([["    parameter", "value", "+- sd", "unit", "bounds", "", "source"], *rows], prose=6)
    terminal.json(_as_json(found))


def _row(key: str, param: Param, value: Value) -> list[str]:
    bounds = f"{param.lo:g} ... {param.hi:g}"
    kind = "fixed" if value.fixed else ""
    sd = f"{value.sd:.2g}" if value.sd is not None else ""
    return [f"    {key}", f"{value.value:.5g}", sd, param.unit, bounds, kind, param.source]


def _as_json(model: Model) -> dict[str, object]:
    effects = {}
    for name, effect in model.effects.items():
        parameters = {}
        for key, param in effect.params.items():
            value = model.values[f"{name}.{key}"]
            parameters[key] = {
                "value": value.value, "sd": value.sd, "fixed": value.fixed, "unit": param.unit,
                "lo": param.lo, "hi": param.hi, "null": param.null, "source": param.source,
            }  # fmt: skip
        effects[name] = {"sentence": effect.sentence(), "equation": effect.equation(), "parameters": parameters}
    return {"about": dict(model.about), "effects": effects}
