"""The drift of an axis as a section of the page: figure and table in the manner of the standard, and for programs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from ballscrew.page.colours import DRAWN
from ballscrew.page.iso230 import HOUR_S, Drift, Range, Spell
from ballscrew.page.picture import legend, sheet, shown
from ballscrew.page.section import Block, Grid, Picture, Points, Section, Words
from ballscrew.report.sections import number
from ballscrew.terminal import Rows, duration
from estimator.record import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TITLE = "Drift of the axis after ISO 230-3"
POSITIONS = ("filter", "alone", "polyline")  # their colours
STEP = 0.02  # of the width, from one mark of a range to the next
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
    yield picture(drift)
    yield Section(f"{drift.recording.name}: ranges", [Grid(table(drift)), Words([meaning(drift)])], level=3)


def meaning(drift: Drift) -> str:
    """What the figures are taken from."""
    left = "compensated: what is left when a control adds what the filter published a tick before"
    if drift.true:
        return f"By the truth of the simulation; {left}."
    return f"By the filter's estimate, +- 2 sd; {left}, two sd of the estimate counted in on both sides."


def place(drift: Drift, i: int) -> str:
    """One of its positions."""
    return f"P{i + 1} at {drift.at_mm[i]:g} mm"


def table(drift: Drift) -> Rows:
    """Ranges of each heating and cooling, and where it ends, not compensated and compensated."""
    names = [name for i in range(len(drift.at_mm)) for name in (place(drift, i), "compensated")]
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
        rest = number(left) if np.isfinite(left) else about.strip()
        cells += [f"{value:{sign}.2f}{about}", rest] if np.isfinite(value) else ["", ""]
    return cells


def picture(drift: Drift) -> Picture:
    """Deviation over time at each position, ranges of the heatings marked; below it what compensation leaves."""
    minutes = drift.recording.time_s / 60
    with sheet(5.0) as drawn:
        above, below = drawn.figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        for axes, values in ((above, drift.whole_um), (below, drift.left_um)):
            _ground(axes, drift, minutes)
            _curves(axes, drift, minutes, values)
        _marks(above, drift, minutes)
        above.margins(y=0.12)
        above.set_ylabel("deviation, µm")
        legend(above)
        below.set(xlabel="time, min", ylabel="compensated, µm")
        below.set_xlim(minutes[0], minutes[-1])
    bands = "" if drift.true else " ± 2 sd"
    return drawn.picture(
        f"{drift.recording.name}: deviation at each position{bands}, above without compensation, the range of each "
        "heating marked at its end; below with it. Grey ground: heating."
    )


def _ground(axes: Axes, drift: Drift, minutes: Array) -> None:
    axes.axhline(0.0, color=DRAWN["faint"], linewidth=0.8)
    for spell in drift.spells:
        if spell.heats:
            axes.axvspan(minutes[spell.first], minutes[spell.last], color=DRAWN["shade"], zorder=0, linewidth=0)


def _curves(axes: Axes, drift: Drift, minutes: Array, values: Array) -> None:
    for i, colour in enumerate(POSITIONS[: len(drift.at_mm)]):
        at, sd = shown(values[:, i]), 2 * drift.sd_um[:, i]
        axes.plot(minutes[at], values[at, i], color=DRAWN[colour], label=place(drift, i))
        if not drift.true:
            axes.fill_between(
                minutes[at], values[at, i] - sd[at], values[at, i] + sd[at], color=DRAWN[colour], alpha=0.2, lw=0
            )  # fmt: skip


def _marks(axes: Axes, drift: Drift, minutes: Array) -> None:
    """The range of each heating at each position, beside its end."""
    step = STEP * (minutes[-1] - minutes[0])
    for spell in drift.spells:
        if not spell.heats:
            continue
        ticks = slice(spell.first, spell.last + 1)
        for i, one in enumerate(drift.ranges(spell)):
            whole, colour = drift.whole_um[ticks, i], DRAWN[POSITIONS[i]]
            if np.isfinite(one.whole_um):
                at, low, high = minutes[spell.last] + (i + 0.7) * step, np.nanmin(whole), np.nanmax(whole)
                axes.errorbar(at, (low + high) / 2, (high - low) / 2, color=colour, capsize=3, lw=1)
                axes.annotate(
                    f"{one.whole_um:.1f}", (at, high), (0, 2), textcoords="offset points", ha="left", color=colour,
                    fontsize=8, rotation=45,
                )  # fmt: skip


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
