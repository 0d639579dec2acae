"""Sections of a title, sentences and a table, as markdown."""

from __future__ import annotations

from collections.abc import Sequence

Rows = Sequence[Sequence[str]]
Section = tuple[str, Sequence[str], Rows]


def page(sections: Sequence[Section]) -> str:
    """All sections; the first row of a table is its head, and no rows are no table."""
    lines: list[str] = []
    for title, sentences, rows in sections:
        lines += [f"# {title}", "", *(f"- {sentence}" for sentence in sentences), ""]
        if rows:
            lines += [*table(rows), ""]
    return "\n".join(lines)


def table(rows: Rows) -> list[str]:
    """Lines of a table, its head first."""
    head, *rest = rows
    return ["| " + " | ".join(row) + " |" for row in (head, ["---"] * len(head), *rest)]
