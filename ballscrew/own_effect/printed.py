"""An effect as a person and as a program read it, with its defaults or with a model's values."""

from collections.abc import Mapping
from typing import Any

from rich.markup import escape

from ballscrew.terminal import Terminal
from estimator.effect import Effect
from estimator.model import Value


def print_effect(terminal: Terminal, effect: Effect | type[Effect], values: Mapping[str, Value] | None = None) -> None:
    """Name, sentence, equation, and a table of its parameters: defaults, or a model's values with sd."""
    terminal.out.print(f"[bold]{effect.name}[/bold]  {escape(effect.sentence())}")
    terminal.say("    " + effect.equation().replace("\n", "\n    "))
    rows = [["    parameter", "value", *(["+- sd"] if values else []), "unit", "bounds", "null", "", "source"]]
    for key, param in effect.params.items():
        value = values[f"{effect.name}.{key}"] if values else Value(param.value, fixed=param.fixed)
        sd = [f"{value.sd:.2g}" if value.sd is not None else ""] if values else []
        null = "" if param.null is None else f"{param.null:g}"
        bounds, fixed = f"{param.lo:g} ... {param.hi:g}", "fixed" if value.fixed else ""
        rows.append([f"    {key}", f"{value.value:.5g}", *sd, param.unit, bounds, null, fixed, escape(param.source)])
    if effect.params:
        terminal.table(rows, prose=len(rows[0]) - 1)


def as_json(effect: type[Effect]) -> dict[str, Any]:
    """The effect for programs."""
    return {
        "sentence": effect.sentence(), "equation": effect.equation(), "trace": effect.trace, "scales": effect.scales,
        "parameters": {key: vars(param) for key, param in effect.params.items()},
    }  # fmt: skip
