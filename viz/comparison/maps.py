"""Maps of two models on one recording, before and after on one scale of colours: what they miss, and the heat missing.

One scale for all recordings of a file: what is bright in one is worse than what is dark in another.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.record import Array
from viz.comparison.compared import ComparedRun, Side
from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.drawing.frames import Frame, colour_bar
from viz.drawing.scale import Range, extent_of, minutes, rounded, symmetric, ticks_of

OPEN_LOOP, INNOVATION, HEAT, BODIES = "open_loop", "innovation", "heat", "bodies"
UNITS = {OPEN_LOOP: "K", INNOVATION: "K", HEAT: "W/m"}
TITLES = {
    OPEN_LOOP: "thermometer − open-loop, mean of 1 min [K]",
    INNOVATION: "innovation of the filter, mean of 1 min [K]",
    HEAT: "heat missing, by place on the screw [W/m]",
}
WIDTHS = {OPEN_LOOP: 1600, INNOVATION: 1600, HEAT: 950}  # about, pixels: as the views they stand in are shaped
LINES = {OPEN_LOOP: 55.0, INNOVATION: 55.0, HEAT: 40.0}  # heights of a line of text there


@dataclass(frozen=True)
class Map:
    """Means of minutes: begins (n,) s and values (n, rows), with names of the rows, the first at the top."""

    rows: Sequence[str]
    begins_s: Array
    values: Array


def map_of(run: ComparedRun, side: Side, what: str) -> Map:
    """A map of one model on one run; without rows where there is nothing to show."""
    if what == HEAT:
        upwards = [f"{place:.0f} mm" for place in side.heat.places_mm]
        return Map(upwards, side.heat.time_s, side.heat.W_m)
    time_s, values = (run.time_s, side.innovation) if what == INNOVATION else (side.misfit_time_s, side.misfit)
    return Map(run.rig.thermometers, *minutes(time_s, values[:, run.rig.is_thermometer]))


def scales_of(runs: Sequence[ComparedRun]) -> dict[str, Range]:
    """Ranges of the colours of each kind of map, for all runs and models. Heat has no spikes to be forgiven."""
    found = {}
    for what in UNITS:
        values = np.concatenate([map_of(run, side, what).values.ravel() for run in runs for side in run.sides])
        low, high = extent_of(values)
        largest = max(-low, high, 1.0)
        found[what] = rounded((-largest, largest), 8) if what == HEAT else symmetric(values)
    return found


def frame_of(found: Map, what: str) -> Frame:
    """The picture's frame."""
    return Frame.of_map(len(found.begins_s), found.rows, WIDTHS[what], LINES[what])


def send(file: Entity, run: ComparedRun, scales: Mapping[str, Range]) -> None:
    """Log the maps of one run."""
    at = file / paths.compared(paths.root(run.name))
    for side, one in run.named.items():
        for what, extent in scales.items():
            found = map_of(run, one, what)
            if found.rows:
                ticks = ticks_of((0.0, len(found.begins_s)), 7)
                texts = [f"{tick:g}" for tick in ticks]
                frame_of(found, what).draw_map(at / what / side, found.values.T, extent, ticks, texts, "time [min]")
        if one.heat.bodies:
            names = [f"{run.said(side)}{name} [W]" for name in one.heat.bodies]
            (at / BODIES / side).lines(names, [paths.COMPARED_AS[side]] * len(names), 1.5)
            (at / BODIES / side).curves(one.heat.time_s, one.heat.W)
    for what, extent in scales.items():
        colour_bar(at / f"{what}_key", extent, UNITS[what])
