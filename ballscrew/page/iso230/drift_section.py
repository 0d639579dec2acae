"""The drift of an axis as a section of the page: figure and table in the manner of the standard, and for programs."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ballscrew.page.iso230.drift import HOUR_S, Drift, Range, Spell
from ballscrew.page.iso230.drift_picture import picture
from ballscrew.page.section import Block, Grid, Points, Section, Words
from ballscrew.terminal import Rows, duration

TITLE = "Drift of the axis after ISO 230-3"
WHAT = [
    "After the test of thermal distortion caused by moving linear axes: the deviation at fixed positions of the table, "
    "P1, P2 and P3, while it is driven and while it cools. It is positive where the screw between the anchor bearing "
    "and the nut has grown.",
    "It is what temperatures along the screw and its model say, not what gauges at the spindle do; of the screw alone.",
]
NOT_COVERED = [
    "The growth of the machine beside the screw: bed, column, table, scale, and the seat of the anchor bearing.",
    "Deviations in the other directions, pitch and yaw.",
    "Whether the cycle was the standard's: feed, pauses to measure and the length of heating and cooling are as they "
    "were in the recording. Rests shorter than 5 min between drives count as driving.",
    "The environmental test (ETVE) and the tests of spindles and rotary axes.",
]


def section(drifts: Sequence[Drift]) -> Section:
    """All recordings, one after the other."""
    parts = [part for one in drifts for part in _of_one(one)]
    missing = Section("What of the standard is not covered", [Points(NOT_COVERED)], level=3)
    return Section(TITLE, [Words(WHAT), *parts, missing], new_page=True)


def _of_one(drift: Drift) -> Iterator[Block]:
    if not any(spell.heats for spell in drift.spells):
        yield Words([f"{drift.recording.name}: no drive in it, nothing to tell."])
        return
    if not np.isfinite(drift.whole_um).any():
        yield Words([f"{drift.recording.name}: the error at the table is not known, as without an anchor bearing."])
        return
    yield picture(drift)
    yield Section(f"{drift.recording.name}: ranges", [Grid(table(drift)), Words([meaning(drift)])], level=3)


def meaning(drift: Drift) -> str:
    """What the figures are taken from."""
    left = "compensated: what is left when a control takes off what the filter published a tick before"
    if drift.true:
        return f"By the truth of the simulation; {left}."
    return f"By the filter's estimate, +- 2 sd; {left}, two sd of the estimate counted in on both sides."


def table(drift: Drift) -> Rows:
    """Ranges of each heating and cooling, and where it ends, not compensated and compensated."""
    names = [name for i in range(len(drift.at_mm)) for name in (drift.place(i), "compensated")]
    return [["um", *names], *(row for spell in drift.spells for row in _rows(drift, spell))]


def _rows(drift: Drift, spell: Spell) -> Iterator[list[str]]:
    ranges, time_s = drift.ranges(spell), drift.recording.time_s
    length = time_s[spell.last] - time_s[spell.first]
    if spell.heats and length > HOUR_S:
        yield _row(f"{spell.name}: range in its first 60 min", ranges, "first_hour_um")
    yield _row(f"{spell.name}: range in {duration(length)}", ranges, "whole_um")
    yield _row(f"{spell.name}: deviation at its end", ranges, "end_um", "+")


def _row(name: str, ranges: Sequence[Range], key: str, sign: str = "") -> list[str]:
    cells = [name]
    for one in ranges:
        value, left, off = getattr(one, key), getattr(one, f"left_{key}"), one.two_sd_um
        about = f" +- {off:.2f}" if off else ""
        rest = f"{round(left, 2) + 0.0:{sign}.2f}" if np.isfinite(left) else about.strip()  # no -0.00
        cells += [f"{value:{sign}.2f}{about}", rest] if np.isfinite(value) else ["", ""]
    return cells


def as_json(drifts: Sequence[Drift]) -> list[dict[str, Any]]:
    """For programs."""
    return [
        {
            "name": drift.recording.name,
            "by": "truth" if drift.true else "estimate",
            "positions_mm": drift.at_mm,
            "spells": [
                {
                    "name": spell.name,
                    "from_s": drift.recording.time_s[spell.first],
                    "to_s": drift.recording.time_s[spell.last],
                    "positions": [asdict(one) for one in drift.ranges(spell)],
                }
                for spell in drift.spells
            ],
        }
        for drift in drifts
    ]
