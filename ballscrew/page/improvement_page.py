"""The report on an improvement as a page."""

import base64
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from ballscrew.page.equations import equations
from ballscrew.page.page import made_by, page, write
from ballscrew.page.section import Block, Formula, Grid, Section, Words, of_report, text_of
from ballscrew.report import sections
from ballscrew.report.improvement_report import Outcome
from ballscrew.report.search.improvement_parts import Part, Program, as_markdown, parts
from estimator.model import Model
from estimator.work import Workers


@dataclass(frozen=True)
class Image:
    """A picture from a file, within the page, and what it shows."""

    path: Path
    caption: str

    def html(self) -> str:
        """A figure."""
        data, caption = base64.b64encode(self.path.read_bytes()).decode(), text_of(self.caption)
        picture = f'<img alt="{caption}" src="data:image/png;base64,{data}">'
        return f"<figure>\n{picture}\n<figcaption>{caption}</figcaption>\n</figure>\n"


def write_report(path: Path, out: Outcome, workers: Workers, draw: Callable[[Path], dict[str, Path]]) -> None:
    """Write the report: as Markdown with its pictures beside it, or, by a name that ends so, as HTML with them in it.

    draw  makes the pictures as STEM-WHAT.png, by what they show
    """
    found = list(parts(out, workers))
    if path.suffix.lower() != ".html":
        path.write_text(as_markdown(found, draw(path.with_suffix(""))), encoding="utf-8")
        return
    with TemporaryDirectory() as folder:
        made = made_by(out.work.rig.name, "improve")
        write(improvement_page(found, draw(Path(folder) / "page"), out.after, made), path)


def improvement_page(found: Sequence[tuple[int, Part]], pictures: Mapping[str, Path], model: Model, made: str) -> str:
    """The report's parts, pictures by what they show, and the model that came out."""
    (_, first), *rest = found
    assert isinstance(first, sections.Section)
    blocks: list[Block] = [Grid(first.rows, prose=(len(first.rows[0]) - 1,))]
    blocks += [block for level, part in rest for block in _blocks(part, level, pictures)]
    return page(first.title, made, first.said, [Section("", blocks), equations(model)])


def _blocks(part: Part, level: int, pictures: Mapping[str, Path]) -> list[Block]:
    if isinstance(part, sections.Section):
        return [of_report(part, level)]
    if isinstance(part, Program):
        return [Section(part.title, [Words([part.said]), Formula(part.text)], level)]
    return [Image(pictures[part.what], part.title)] if part.what in pictures else []
