"""How things stand at a moment: what is to be read at a glance, and all the rest in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from estimator.step import TableErrors

Tone = Literal["value", "valid", "invalid", "stale"]  # stale: grey, for nobody may take it for a value of now


@dataclass(frozen=True)
class Glance:
    """One value in large letters, what it is above it, and since when or why below it."""

    caption: str
    value: str
    below: str
    tone: Tone


@dataclass(frozen=True)
class Standing:
    """What is so at a time.

    glances  what is read from across the room
    words    everything else, as markdown
    table    the error at the table, were it anywhere on its stroke; None where there is no such thing, or it is old
    """

    time_s: float
    glances: tuple[Glance, ...]
    words: str
    table: TableErrors | None = None
