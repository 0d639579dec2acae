"""Sections of a title, sentences and a table, as markdown or on the terminal; errors as its cells, and for programs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ballscrew.terminal import Rows, Terminal
from estimator.accuracy.noise_floor import Error
from estimator.model import Value

HORIZONS = {"one_step": "one tick ahead", "ahead": "10 minutes ahead", "open_loop": "model alone (open loop)"}
KEYS = {"one_step": "one_step", "ahead": "ahead_10min", "open_loop": "open_loop"}


@dataclass(frozen=True)
class Section:
    """A title, sentences, and a table with its head first; no rows are no table."""

    title: str
    said: Sequence[str] = ()
    rows: Rows = ()


def markdown(sections: Sequence[Section], level: int = 1) -> str:
    """All sections as markdown, under headings of a level."""
    lines: list[str] = []
    for section in sections:
        lines += [f"{'#' * level} {section.title}", ""]
        lines += [*(f"- {sentence}" for sentence in section.said), ""] if section.said else []
        lines += [*table(section.rows), ""] if section.rows else []
    return "\n".join(lines)


def table(rows: Rows) -> list[str]:
    """Lines of a table in markdown, its head first."""
    head, *rest = rows
    return ["| " + " | ".join(row) + " |" for row in (head, ["---"] * len(head), *rest)]


def print_sections(terminal: Terminal, sections: Sequence[Section]) -> None:
    """Tables below each other, each but the first under its title; what is said of the first comes last."""
    first, *rest = sections
    terminal.table(first.rows)
    for section in rest:
        terminal.say("\n" + "\n".join([section.title, *section.said]))
        terminal.table(section.rows)
    for sentence in first.said:
        terminal.say(sentence)


def number(value: float, digits: int = 2) -> str:
    """A number; nothing where there is none."""
    return f"{value:.{digits}f}" if np.isfinite(value) else ""


def cells(errors: Sequence[Error]) -> list[str]:
    """K and um of each error."""
    return [cell for e in errors for cell in (number(e.temperature_K, 3), number(e.elongation_um))]


def by_horizon(errors: Mapping[str, Error]) -> dict[str, Mapping[str, float]]:
    """Errors by horizon for programs."""
    return {KEYS[key]: vars(error) for key, error in errors.items()}


def with_sd(value: Value, unit: str) -> str:
    """A value to the first digit of its sd: 923 +- 46 s, 2.1 +- 0.2; of a sd that is not known, to three digits."""
    per = "" if unit == "1" else f" {unit}"
    if not value.sd or not np.isfinite(value.sd):
        return f"{value.value:.3g}{per}"
    digits = max(0, -int(np.floor(np.log10(value.sd))))
    return f"{value.value:.{digits}f} +- {value.sd:.{digits}f}{per}"
