"""ballscrew add: add an effect to a model."""

from dataclasses import replace
from pathlib import Path

import click

from ballscrew.completion import effect_names, words
from ballscrew.options import PATH, model_output, rig_option, terminal_options
from ballscrew.own_effect.named import named_effect
from ballscrew.own_effect.patience import patience
from ballscrew.terminal import Terminal
from ballscrew.workspace import open_rig
from estimator.battery.admitted import admit
from estimator.errors import SetupError
from estimator.model import Model
from estimator.rig_folder.model_toml import load_model, save_model


@click.command("add")
@click.argument("effect", metavar="EFFECT", shell_complete=words(effect_names, or_file=True))
@click.argument("model_path", type=PATH, metavar="MODEL")
@model_output("Write the model here; the same file to change it in place.")
@rig_option("Rig folder that it must fit; else the nearest one at or above MODEL, else the built-in rig.")
@terminal_options
def command(terminal: Terminal, effect: str, model_path: Path, out: Path, rig_path: Path | None) -> None:
    """Add EFFECT to MODEL, at its default values, each with the standard deviation that its source leaves.

    EFFECT is an effect of the catalogue, or your own: FILE.py:Class. That file is Python, and runs.
    """
    one, model = named_effect(effect), load_model(model_path)
    name = one.effect.name
    if name in model.effects:
        raise SetupError(f"{model_path} has the effect '{name}' already; change its values in the file, or fit them")
    added = _in_doubt(one.used_by(model + one.effect), name)
    rig = open_rig([model_path], rig_path, terminal)
    with patience(one.use):
        admit(added, rig)
    if missing := [other for other in one.effect.scales if other not in model.effects]:
        terminal.warn(f"{name} acts on {', '.join(missing)} too, which {model_path} has not: without it, it does less")
    save_model(added, out)
    terminal.say(f"{out}: {name} added to {len(model.effects)} effects, at its defaults")
    terminal.say(f"next: ballscrew fit LOG... --model {out} -o MODEL")
    parameters = {key: added[f"{name}.{key}"] for key in one.effect.params}
    terminal.json({"model": str(out), "effect": name, "parameters": parameters, "missing": missing})


def _in_doubt(model: Model, name: str) -> Model:
    """The model with the parameters of an effect that nobody has fitted known as well as their sources say."""
    params = {f"{name}.{key}": param for key, param in model.effects[name].params.items() if not param.fixed}
    told = {path: replace(model.values[path], sd=param.sd) for path, param in params.items()}
    return replace(model, values={**model.values, **told})
