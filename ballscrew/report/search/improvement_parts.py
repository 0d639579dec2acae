"""The report on an improvement: its parts in order, and as Markdown with pictures beside it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ballscrew.report import diagnosis_report
from ballscrew.report.comparison_report import sections
from ballscrew.report.felt_report import felt_section
from ballscrew.report.improvement_report import Outcome, added, recordings_kept, steps_section
from ballscrew.report.search.composed_words import composed_sentence
from ballscrew.report.sections import Section, markdown
from ballscrew.report.use_report import left_out
from ballscrew.workspace import Loaded, runs_of
from estimator.accuracy.compare import compare
from estimator.missing_heat.diagnose import diagnose
from estimator.model import Model
from estimator.work import Workers


@dataclass(frozen=True)
class Shown:
    """A picture: what it is called among the pictures, and its title."""

    what: str
    title: str


@dataclass(frozen=True)
class Program:
    """A title, a sentence, and the lines of a program."""

    title: str
    said: str
    text: str


Part = Section | Shown | Program


def parts(out: Outcome, workers: Workers) -> Iterator[tuple[int, Part]]:
    """All of the report in order, each under headings of a level."""
    yield 1, steps_section(out)
    yield 2, Shown("steps", "Error of the model alone, step by step")
    if out.felt:
        yield 2, felt_section(out.felt)
    yield 2, _given(out)
    if failed := left_out(out.improvement.uses, out.work.rig):
        yield 2, Section("Sensors that failed", (), failed)
    yield 2, _effects(out)
    for made in out.improvement.composed:
        yield 3, Program(f"{made.effect.name}, composed", composed_sentence(made), made.text)
    yield 2, _parameters(out.before, out.after)
    yield 2, Section("Where it fails")
    yield from _diagnosed(out, workers)
    yield 2, Shown("residuals", "Measured minus the model alone")
    yield 2, Shown("missing-heat", "Heat that the model alone lacks")
    for what, some in (("used", out.work.loaded), ("held out", out.work.held_out)):
        if some:
            runs = runs_of(out.work.rig, some, workers)
            comparisons = [replace(compare(model, runs), held_out=None) for model in out.models]
            yield from ((3, replace(one, title=f"Recordings {what}: {one.title}")) for one in sections(comparisons))


def as_markdown(found: Sequence[tuple[int, Part]], pictures: Mapping[str, Path]) -> str:
    """The report as Markdown; pictures by what they show, beside it."""
    return "\n".join(text for level, part in found if (text := _markdown(part, level, pictures)))


def _markdown(part: Part, level: int, pictures: Mapping[str, Path]) -> str:
    if isinstance(part, Section):
        return markdown([part], level)
    if isinstance(part, Program):
        return f"{'#' * level} {part.title}\n\n{part.said}\n\n```python\n{part.text}```\n"
    return f"![{part.title}]({pictures[part.what].name})\n" if part.what in pictures else ""


def _diagnosed(out: Outcome, workers: Workers) -> Iterator[tuple[int, Part]]:
    """What `diagnose` says of each model, by the recordings kept; the errors of all horizons stand further below."""
    runs = runs_of(out.work.rig, recordings_kept(out.improvement, out.work.loaded), workers)
    for model in out.models:
        found = diagnose(model, runs)
        yield 3, Section(model.name, found.sentences)
        _, *tables = diagnosis_report.sections(found, ())
        yield from ((4, table) for table in tables)


def _given(out: Outcome) -> Section:
    rows = [["", ""], ["model", out.before.name], ["rig", out.work.rig.name]]
    rows += [["recordings used", _names(out.work.loaded)], ["recordings held out", _names(out.work.held_out) or "none"]]
    own = ", ".join(dict.fromkeys([*out.before.use, *out.own]))
    return Section("What was given", (), [*rows, ["effects of one's own", own or "none"]])


def _effects(out: Outcome) -> Section:
    """What each effect that was added says, and its rivals."""
    rows = [
        [new, out.after.effects[new].sentence(), ", ".join(step.tie)]
        for names, step in zip(added(out.improvement.kept), out.improvement.kept, strict=True)
        for new in filter(None, names.split(" + "))
    ]
    if not rows:
        return Section("Effects added", ["none"])
    return Section("Effects added", (), [["effect", "what it is", "as good, by these recordings"], *rows])


def _names(some: Sequence[Loaded]) -> str:
    return ", ".join(one.path.name for one in some)


def _parameters(before: Model, after: Model) -> Section:
    """Parameters that are new or that moved."""
    rows = []
    for path, value in after.values.items():
        old = before.values.get(path)
        if old is None or old.value != value.value:
            sd = "fixed" if value.fixed else f"{value.sd:.2g}" if value.sd is not None else ""
            cells = [f"{old.value:.4g}" if old else "new", f"{value.value:.4g}", sd, after.param(path).unit]
            rows.append([path, *cells])
    if not rows:
        return Section("Parameters", ["none was added or changed"])
    return Section("Parameters added or changed", (), [["parameter", "before", "after", "± sd", "unit"], *rows])
