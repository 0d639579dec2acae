"""Maps of two models on one recording, before and after on one scale of colours: what they miss, and the heat missing.

One scale for all recordings of a file: what is bright in one is worse than what is dark in another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import rerun as rr

from estimator.record import Array
from viz.comparison.curves import COLOURS, said, sides_of
from viz.drawing import paths, series
from viz.drawing.axes import colour_bar, words
from viz.drawing.frame import NAMES, ROW, Frame
from viz.drawing.scale import DIVERGING, Range, coloured, extent_of, minutes, rounded, symmetric, ticks_of

if TYPE_CHECKING:
    from viz.comparison.compared import Compared, Side

OPEN_LOOP, INNOVATION, HEAT, BODIES = "open_loop", "innovation", "heat", "bodies"
UNITS = {OPEN_LOOP: "K", INNOVATION: "K", HEAT: "W/m"}
TITLES = {
    OPEN_LOOP: "thermometer − open-loop, mean of 1 min [K]",
    INNOVATION: "innovation of the filter, mean of 1 min [K]",
    HEAT: "heat missing, by place on the screw [W/m]",
}
WIDTHS = {OPEN_LOOP: 1600, INNOVATION: 1600, HEAT: 950}  # about, pixels: as the views they stand in are shaped
LINES = {OPEN_LOOP: 55.0, INNOVATION: 55.0, HEAT: 40.0}  # heights of a line of text there

Scales = dict[str, Range]


@dataclass(frozen=True)
class Map:
    """Means of minutes: begins (n,) s and values (n, rows), with names of the rows, the first at the top."""

    rows: Sequence[str]
    begins_s: Array
    values: Array
    unit: str


def map_of(run: Compared, side: Side, what: str) -> Map:
    """A map of one model on one run; without rows where there is nothing to show."""
    if what == HEAT:
        upwards = [f"{place:.0f} mm" for place in side.heat.places_mm]
        return Map(upwards, side.heat.time_s, side.heat.W_m, UNITS[what])
    time_s, values = (run.time_s, side.innovation) if what == INNOVATION else (side.misfit_time_s, side.misfit)
    return Map(run.rig.thermometers, *minutes(time_s, values[:, run.thermometers]), UNITS[what])


def scales_of(runs: Sequence[Compared]) -> Scales:
    """Ranges of the colours of each kind of map, for all runs and models. Heat has no spikes to be forgiven."""
    found = {}
    for what in UNITS:
        values = np.concatenate([map_of(run, side, what).values.ravel() for run in runs for side in run.sides])
        low, high = extent_of(values)
        largest = max(-low, high, 1.0)
        found[what] = rounded((-largest, largest), 8) if what == HEAT else symmetric(values)
    return found


def frame_of(found: Map, what: str) -> Frame:
    """The picture's frame: each minute is equally many pixels wide."""
    wide = max(1, round(WIDTHS[what] / len(found.begins_s)))
    return Frame(len(found.begins_s) * wide, found.rows, NAMES, LINES[what])


def send(rec: rr.RecordingStream, run: Compared, scales: Scales) -> None:
    """Log the maps of one run."""
    root = paths.root(run.name)
    for side, one in sides_of(run).items():
        for what, extent in scales.items():
            found = map_of(run, one, what)
            if found.rows:
                _draw(rec, paths.compared(root, what, side), found, what, extent)
        if one.heat.bodies:
            at = paths.compared(root, BODIES, side)
            names = [f"{said(side, run)}{name} [W]" for name in one.heat.bodies]
            series.lines(rec, at, names, [COLOURS[side]] * len(names), 1.5)
            series.send(rec, at, one.heat.time_s, one.heat.W)
    for what, extent in scales.items():
        labels = [f"{value:+g} {UNITS[what]}" if value else f"0 {UNITS[what]}" for value in np.linspace(*extent, 5)]
        shades = coloured(np.linspace(*extent, 64), extent, DIVERGING)
        colour_bar(rec, paths.compared(root, f"{what}_key"), shades, labels)


def _draw(rec: rr.RecordingStream, at: str, found: Map, what: str, extent: Range) -> None:
    frame = frame_of(found, what)
    wide = frame.width // len(found.begins_s)
    shades = coloured(found.values.T, extent, DIVERGING)[..., :3]
    ticks = ticks_of((0.0, len(found.begins_s)), 7)
    pixels = shades.repeat(ROW, axis=0).repeat(wide, axis=1)
    frame.draw(rec, at, pixels, wide * ticks, [f"{tick:g}" for tick in ticks])
    words(rec, f"{at}/title", [(frame.width / 2, frame.height + 1.7 * frame.line)], ["time [min]"])
