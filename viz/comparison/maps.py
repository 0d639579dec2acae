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

OPEN_LOOP, INNOVATION, HEAT, BROUGHT, BODIES = "open_loop", "innovation", "heat", "brought", "bodies"
UNITS = {OPEN_LOOP: "K", INNOVATION: "K", HEAT: "W/m", BROUGHT: "W/m"}
TITLES = {
    OPEN_LOOP: "thermometer − open-loop, mean of 1 min [K]",
    INNOVATION: "innovation of the filter, mean of 1 min [K]",
    HEAT: "heat missing, by place on the screw [W/m]",
}
# about, pixels: as the views they stand in are shaped
WIDTHS = {OPEN_LOOP: 1600, INNOVATION: 1600, HEAT: 950, BROUGHT: 950}
LINES = {OPEN_LOOP: 55.0, INNOVATION: 55.0, HEAT: 40.0, BROUGHT: 40.0}  # heights of a line of text there


@dataclass(frozen=True)
class Map:
    """Means of minutes: begins (n,) s and values (n, rows), with names of the rows, the first at the top."""

    rows: Sequence[str]
    begins_s: Array
    values: Array


def map_of(run: ComparedRun, side: Side, what: str) -> Map:
    """A map of one model on one run; without rows where there is nothing to show."""
    if what in (HEAT, BROUGHT):
        heat = side.heat if what == HEAT else side.brought
        if heat is None:
            return Map((), np.empty(0), np.empty((0, 0)))
        return Map([f"{place:.0f} mm" for place in heat.places_mm], heat.time_s, heat.W_m)
    time_s, values = (run.time_s, side.innovation) if what == INNOVATION else (side.misfit_time_s, side.misfit)
    return Map(run.rig.thermometers, *minutes(time_s, values[:, run.rig.is_thermometer]))


def scales_of(runs: Sequence[ComparedRun]) -> dict[str, Range]:
    """Ranges of the colours of each kind of map, for all runs and models.

    Heat has no spikes to be forgiven; what is missing and what an effect brings are to be compared: one range.
    """
    found = {what: symmetric(_values(runs, what)) for what in (OPEN_LOOP, INNOVATION)}
    low, high = extent_of(_values(runs, HEAT), _values(runs, BROUGHT))
    largest = max(-low, high, 1.0)
    return found | dict.fromkeys((HEAT, BROUGHT), rounded((-largest, largest), 8))


def _values(runs: Sequence[ComparedRun], what: str) -> Array:
    return np.concatenate([map_of(run, side, what).values.ravel() for run in runs for side in run.sides])


def brings(run: ComparedRun) -> str:
    """What the map of heat that is brought shows; nothing where there is none."""
    found = run.sides[-1].brought
    return f"heat {_by(run)} [{UNITS[BROUGHT]}]" if found is not None and found.W_m.any() else ""


def _by(run: ComparedRun) -> str:
    return f"that {' and '.join(run.added)} {'brings' if len(run.added) == 1 else 'bring'}"


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
        if one.brought is not None and one.brought.W.any():
            names = [f"{_by(run)} into {name} [W]" for name in one.brought.bodies]
            (at / BODIES / BROUGHT).lines(names, [paths.CROSS_VALIDATED] * len(names), 1.5)
            (at / BODIES / BROUGHT).curves(one.brought.time_s, one.brought.W)
    for what in (OPEN_LOOP, INNOVATION, HEAT):
        colour_bar(at / f"{what}_key", scales[what], UNITS[what])
