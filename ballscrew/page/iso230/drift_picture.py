"""The drift of an axis in the manner of the standard's figure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ballscrew.page.iso230.drift import Drift
from ballscrew.page.picture import DRAWN, legend, sheet, shown
from ballscrew.page.section import Picture
from estimator.record import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POSITIONS = ("filter", "alone", "polyline")  # their colours
STEP = 0.02  # of the width, from one mark of a range to the next


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
        axes.plot(minutes[at], values[at, i], color=DRAWN[colour], label=drift.place(i))
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
                    fontsize=8, rotation=45, bbox={"facecolor": DRAWN["paper"], "lw": 0, "alpha": 0.8, "pad": 0.5},
                )  # fmt: skip
