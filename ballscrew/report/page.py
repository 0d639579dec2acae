"""Sections of a title, sentences and a table, as markdown."""

from __future__ import annotations

from collections.abc import Sequence

Rows = Sequence[Sequence[str]]
Section = tuple[str, Sequence[str], Rows]


def page(sections: Sequence[Section], level: int = 1) -> str:
    """All sections under headings of a level; the first row of a table is its head, and no rows are no table."""
    lines: list[str] = []
    for title, sentences, rows in sections:
        lines += [f"{'#' * level} {title}", ""]
        lines += [*(f"- {sentence}" for sentence in sentences), ""] if sentences else []
        lines += [*table(rows), ""] if rows else []
    return "\n".join(lines)


def table(rows: Rows) -> list[str]:
    """Lines of a table, its head first."""
    head, *rest = rows
    return ["| " + " | ".join(row) + " |" for row in (head, ["---"] * len(head), *rest)]
