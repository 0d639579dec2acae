"""The kept figures: one file that a person can read."""

import json
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from estimator.errors import SetupError

from .compare import TOLERANCE, Tolerance, digits
from .measure import PAPER, Figures

HEADER = """\
# Figures of the filter on recordings, kept to compare a later model with: docs/tuning.md says what they mean.
# `make tuning REASON="why"` writes this file. By hand only: the list of recordings, and the tolerances.
"""


@dataclass
class Kept:
    """What kept.toml holds.

    model    fingerprint of the model that was measured
    reasons  why each renewal was made, the oldest first; how many figures got better and worse; the model's fingerprint
    """

    model: str = ""
    recordings: list[str] = field(default_factory=list)
    tolerance: Tolerance = field(default_factory=lambda: TOLERANCE)
    reasons: list[dict[str, str | int]] = field(default_factory=list)
    figures: Figures = field(default_factory=dict)


def kept_path(folder: Path) -> Path:
    """Where the figures of a rig folder are kept: in it; those of the paper's rig beside these tests."""
    return (Path(__file__).parent if folder.resolve() == PAPER else folder) / "kept.toml"


def read(path: Path) -> Kept:
    """Read the file; none is a SetupError that says how to make one."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise SetupError(f'{path}: no figures kept yet; make tuning REASON="first figures" keeps them') from None
    except tomllib.TOMLDecodeError as error:
        raise SetupError(f"{path}: {error}") from None
    figures = {
        (recording, channel, figure): float(value)
        for recording, channels in table["figures"].items()
        for channel, row in channels.items()
        for figure, value in row.items()
    }
    return Kept(table["model"], table["recordings"], table["tolerance"], table["reason"], figures)


def write(path: Path, kept: Kept) -> None:
    """Write the file, figures with four digits."""
    path.write_text("\n".join(_lines(kept)).rstrip() + "\n", encoding="utf-8")


def _lines(kept: Kept) -> Iterator[str]:
    yield HEADER
    yield f"model = {_text(kept.model)}  # fingerprint of its effects and values"
    yield f"recordings = [{', '.join(map(_text, kept.recordings))}]"
    yield "\n# What still counts as the same: a share of NIS and of errors, a difference of whiteness and of shares."
    for group, row in kept.tolerance.items():
        yield f"[tolerance.{group}]" + ("" if group == "all" else "  # of single channels, where it differs")
        yield from (f"{figure} = {value:g}" for figure, value in row.items())
        yield ""
    for reason in kept.reasons:
        yield "[[reason]]"
        yield from (f"{name} = {_text(value) if isinstance(value, str) else value}" for name, value in reason.items())
        yield ""
    yield from _tables(kept.figures)


def _tables(figures: Figures) -> Iterator[str]:
    rows: dict[str, dict[str, list[str]]] = {}
    for (recording, channel, figure), value in figures.items():
        rows.setdefault(recording, {}).setdefault(channel, []).append(f"{figure} = {digits(value)}")
    for recording, channels in rows.items():
        yield f"[figures.{_text(recording)}]"
        yield from (f"{_key(channel)} = {{ {', '.join(row)} }}" for channel, row in channels.items())
        yield ""


def _text(value: str) -> str:
    return json.dumps(value, ensure_ascii=False)


def _key(name: str) -> str:
    return name if re.fullmatch("[A-Za-z0-9_-]+", name) else _text(name)
