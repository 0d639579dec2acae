"""Sections of a title, sentences and a table, as markdown or on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ballscrew.terminal import Rows, Terminal


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
