"""ballscrew effects: the catalogue of effects, one of them in full, and whether an effect passes the battery."""

from pathlib import Path

import click
from rich.markup import escape

from ballscrew.completion import effect_names, words
from ballscrew.options import model_option, rig_option, terminal_options
from ballscrew.own_effect.named import Named, named_effects
from ballscrew.own_effect.printed import as_json, print_effect
from ballscrew.terminal import Terminal
from ballscrew.workspace import open_model, open_rig
from estimator.battery.battery import Finding, battery
from estimator.effect import Effect
from estimator.effects import HEAT, MOUNTING, READING, STRUCTURE
from estimator.errors import InputError, SetupError
from estimator.model import Model
from estimator.rig import Rig

KINDS = {"structure": STRUCTURE, "mounting": MOUNTING, "heat": HEAT, "reading": READING}


@click.command("effects")
@click.argument("name", required=False, metavar="[NAME]", shell_complete=words(effect_names, or_file=True))
@click.option("--check", is_flag=True, help="Run the battery on it that every effect must pass.")
@rig_option("Check it on this rig folder; else the nearest at or above the file, else the built-in rig.")
@model_option("Check it beside this model's effects; else the rig folder's model.toml.")
@terminal_options
def command(
    terminal: Terminal, name: str | None, check: bool, rig_path: Path | None, model_path: Path | None
) -> int:  # fmt: skip
    """Print the catalogue, or the effect NAME with its equation, its parameters and what it leaves in the readings.

    NAME is an effect of the catalogue, or your own: FILE.py or FILE.py:Class. That file is Python, and runs.
    """
    if name is None:
        if check:
            raise SetupError("--check: of which effect? Name it: ballscrew effects NAME --check")
        _print_catalogue(terminal)
        terminal.json({kind: {effect.name: as_json(effect) for effect in kept} for kind, kept in KINDS.items()})
        return 0
    found, told, failed = named_effects(name), {}, False
    for one in found:
        _print(terminal, one.effect)
        told[one.effect.name] = as_json(one.effect)
    if check:
        rig = open_rig([found[0].file] if found[0].file else [], rig_path, terminal)
        model = open_model(rig, model_path, terminal)
        for one in found:
            findings = _checked(terminal, one, model, rig)
            told[one.effect.name]["checks"] = [vars(finding) for finding in findings]
            failed |= not all(finding.ok for finding in findings)
    terminal.json(told)
    return InputError.exit_code if failed else 0


def _print_catalogue(terminal: Terminal) -> None:
    for kind, effects in KINDS.items():
        terminal.table([["effect", ""], *([effect.name, effect.sentence()] for effect in effects)], prose=1, title=kind)
        terminal.say()
    terminal.say(
        "ballscrew effects NAME prints one of them in full, ballscrew add NAME MODEL -o MODEL adds it to a model"
    )


def _print(terminal: Terminal, effect: type[Effect]) -> None:
    print_effect(terminal, effect)
    if effect.trace:
        terminal.say(f"    leaves: {effect.trace}")
    if effect.scales:
        terminal.say(f"    needs in the model, where it acts on them: {', '.join(effect.scales)}")
    terminal.say()


def _checked(terminal: Terminal, one: Named, model: Model, rig: Rig) -> list[Finding]:
    findings = battery(one.effect, model, rig)
    rows = [[f"    {f.check}", "passes" if f.ok else "FAILS", escape(f.detail)] for f in findings]
    terminal.table([["    check", "", ""], *rows], prose=2)
    terminal.say()
    if failing := [finding for finding in findings if not finding.ok]:
        terminal.error(f"{one.use} fails: " + "; ".join(f"{finding.check} ({finding.detail})" for finding in failing))
    else:
        terminal.say(f"{one.use} passes all checks on {rig.name}")
    return findings
