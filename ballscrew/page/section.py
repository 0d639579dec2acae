"""What a page is made of: sections of words, tables, formulas and pictures, each of which writes itself as HTML.

All text is escaped here and nowhere else: names of recordings, channels and effects come from outside.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Protocol

from ballscrew.report import sections
from ballscrew.terminal import Rows

# letters that a terminal does without
PRINTED = {r"\bum\b": "µm", r"\bdegC\b": "°C", r"\+-": "±", r"\b(\d+) x\b": r"\1 ×"}


def text_of(words: str) -> str:
    """Words as a page has them."""
    for plain, printed in PRINTED.items():
        words = re.sub(plain, printed, words)
    return escape(words)


class Block(Protocol):
    """A part of a section."""

    def html(self) -> str:
        """Itself, as HTML."""


@dataclass(frozen=True)
class Words:
    """Sentences, each a paragraph."""

    said: Sequence[str]

    def html(self) -> str:
        return "".join(f"<p>{text_of(sentence)}</p>\n" for sentence in self.said)


@dataclass(frozen=True)
class Points:
    """Sentences as a list."""

    said: Sequence[str]

    def html(self) -> str:
        points = "".join(f"<li>{text_of(sentence)}</li>\n" for sentence in self.said)
        return f"<ul>\n{points}</ul>\n" if points else ""


@dataclass(frozen=True)
class Grid:
    """A table, its head first: a name, then numbers with their unit in the head; columns of `prose` hold text."""

    rows: Rows
    prose: Sequence[int] = ()

    def html(self) -> str:
        head, *rest = self.rows
        lines = "\n".join(self._row(row, "td") for row in rest)
        table = f"<table>\n<thead>{self._row(head, 'th')}</thead>\n<tbody>\n{lines}\n</tbody>\n</table>"
        return f'<div class="wide">{table}</div>\n'

    def _row(self, row: Sequence[str], tag: str) -> str:
        text = {0, *self.prose}
        cells = (
            f'<{tag} class="text">{text_of(cell)}</{tag}>' if i in text else f"<{tag}>{text_of(cell)}</{tag}>"
            for i, cell in enumerate(row)
        )  # fmt: skip
        return f"<tr>{''.join(cells)}</tr>"


@dataclass(frozen=True)
class Formula:
    """Lines as they are, equations or a program."""

    text: str

    def html(self) -> str:
        return f"<pre>{escape(self.text)}</pre>\n" if self.text else ""


@dataclass(frozen=True)
class Picture:
    """A drawing as SVG, in the page's colours, and what it shows."""

    svg: str
    caption: str

    def html(self) -> str:
        caption = text_of(self.caption)
        return f"<figure>\n{self.svg}\n<figcaption>{caption}</figcaption>\n</figure>\n"


@dataclass(frozen=True)
class Section:
    """A title and what stands below it, parts of it with titles of their own among that.

    new_page  on paper it begins one
    """

    title: str
    blocks: Sequence[Block]
    level: int = 2
    new_page: bool = False

    def html(self) -> str:
        inside = "".join(block.html() for block in self.blocks)
        title = f"<h{self.level}>{text_of(self.title)}</h{self.level}>\n" if self.title else ""
        begin = '<section class="new-page">' if self.new_page else "<section>"
        return f"{begin}\n{title}{inside}</section>\n"


def of_report(one: sections.Section, level: int = 3) -> Section:
    """A section of a report as one of a page."""
    prose = [i for i, cells in enumerate(zip(*one.rows[1:], strict=True)) if any(cell[:1].isalpha() for cell in cells)]
    return Section(one.title, [*([Grid(one.rows, prose)] if one.rows else []), Points(one.said)], level)
