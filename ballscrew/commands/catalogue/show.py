"""ballscrew show: a model as equations with values, units, bounds and sources."""

from pathlib import Path

import click

from ballscrew.options import PATH, terminal_options
from ballscrew.own_effect.patience import patience
from ballscrew.own_effect.printed import print_effect
from ballscrew.terminal import Terminal
from ballscrew.workspace import open_rig
from estimator.battery.admitted import admit
from estimator.effect import Param
from estimator.model import Value
from estimator.rig_folder.model_toml import load_model


@click.command("show")
@click.argument("model", type=PATH, metavar="MODEL")
@terminal_options
def command(terminal: Terminal, model: Path) -> None:
    """Print MODEL: one paragraph for each effect, with its equation and a table of its parameters."""
    with patience(model):
        found = load_model(model)
        if found.use:
            admit(found, open_rig([model], None, terminal))
    terminal.say(f"{model}: {len(found.effects)} effects, {len(found.free())} free parameters")
    if found.about.get("fitted_on"):
        terminal.say("fitted on " + ", ".join(found.about["fitted_on"]))
    told = {}
    for name, effect in found.effects.items():
        terminal.say()
        print_effect(terminal, effect, found.values)
        parameters = {key: _told(param, found.values[f"{name}.{key}"]) for key, param in effect.params.items()}
        told[name] = {"sentence": effect.sentence(), "equation": effect.equation(), "parameters": parameters}
    terminal.json({"about": found.about, "effects": told})


def _told(param: Param, value: Value) -> dict[str, object]:
    """A parameter for programs: its value in the model, and what the effect says of it."""
    return {**vars(value), **{key: getattr(param, key) for key in ("unit", "lo", "hi", "null", "source")}}
