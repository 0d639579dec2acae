"""Maps of two models on one recording, before and after on one scale of colours: what they miss, and the heat missing.

One scale for all recordings of a file: what is bright in one is worse than what is dark in another. What a model after
still misses is shown once more on a scale of its own.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from estimator.record import Array
from viz.comparison.compared import ComparedRun, HeatMap, Side
from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.drawing.scale import Range, extent_of, rounded, symmetric, widened
from viz.figures.map import Map, Sheet, means

OPEN_LOOP, INNOVATION, HEAT, BROUGHT, BODIES = "open_loop", "innovation", "heat", "brought", "bodies"
AFTER_ALONE = "after_alone"  # in place of a side: the model after on its own scale
UNITS = {OPEN_LOOP: "K", INNOVATION: "K", HEAT: "W/m", BROUGHT: "W/m"}
SAID = {
    OPEN_LOOP: "thermometer − open-loop [K]",
    INNOVATION: "innovation of the filter [K]",
    HEAT: "heat missing [W/m]",
}
PHASES = {"drive": "D", "early_stop": "S", "late_stop": "R"}
STRETCHES = "D drive, S 10 min after, R rest: begin [min]"
MOST_TEXTS = 4  # below a map of stretches
NONE = Map((), np.empty(0), np.empty(0), np.empty(0), (), "")
PAGE = 1350.0, 285.0  # points: maps beside each other share the width


def map_of(run: ComparedRun, side: Side, what: str) -> Map:
    """A map of one model on one run; without rows where there is nothing to show."""
    if what in (HEAT, BROUGHT):
        heat = side.heat if what == HEAT else side.brought
        return _stretches(heat) if heat is not None else NONE
    time_s, values = (run.time_s, side.innovation) if what == INNOVATION else (side.misfit_time_s, side.misfit)
    return Map.over_time(run.rig.thermometers, *means(time_s, values[:, run.rig.is_thermometer]))


def _stretches(heat: HeatMap) -> Map:
    """A column for each drive, the ten minutes after it, and rest."""
    texts = [f"{PHASES[phase]} {begin_s / 60:.0f}" for phase, begin_s in zip(heat.phases, heat.time_s, strict=True)]
    shown = np.arange(0, len(texts), -(-len(texts) // MOST_TEXTS))
    rows = [f"{place:.0f}" for place in heat.places_mm]
    return Map(rows, heat.time_s, heat.W_m, shown + 0.5, [texts[k] for k in shown], STRETCHES)


def scales_of(runs: Sequence[ComparedRun]) -> dict[str, Range]:
    """Ranges of the colours of each kind of map, for all runs and models.

    Heat has no spikes to be forgiven; what is missing and what an effect brings are to be compared: one range.
    """
    found = {what: symmetric(_values(runs, what)) for what in (OPEN_LOOP, INNOVATION)}
    return found | dict.fromkeys((HEAT, BROUGHT), _even(_values(runs, HEAT), _values(runs, BROUGHT)))


def _values(runs: Sequence[ComparedRun], what: str) -> Array:
    return np.concatenate([map_of(run, side, what).values.ravel() for run in runs for side in run.sides])


def _even(*values: Array) -> Range:
    """A range around zero that holds all values."""
    largest = max(*map(abs, extent_of(*values)), 1.0)
    return rounded((-largest, largest), 8)


def brings(run: ComparedRun) -> str:
    """What the map of heat that is brought shows; nothing where there is none."""
    found = run.sides[-1].brought
    return f"heat {_by(run)} [{UNITS[BROUGHT]}]" if found is not None and found.W_m.any() else ""


def _by(run: ComparedRun) -> str:
    return f"that {' and '.join(run.added)} {'brings' if len(run.added) == 1 else 'bring'}"


def sheets(run: ComparedRun, what: str, extent: Range) -> dict[str, Sheet]:
    """The maps of one kind, as they stand beside each other, by where they are logged."""
    found = {f"{what}/{side}": (map_of(run, one, what), extent) for side, one in run.named.items()}
    if len(run.sides) > 1:
        after = map_of(run, run.sides[-1], what)
        found[f"{what}/{AFTER_ALONE}"] = after, (_even if what == HEAT else symmetric)(after.values)
    if what == HEAT and brings(run):
        found[f"{BROUGHT}/{[*run.named][-1]}"] = map_of(run, run.sides[-1], BROUGHT), extent
    view = PAGE[0] / len(found), PAGE[1]
    return {at: Sheet(one, own, UNITS[what], view) for at, (one, own) in found.items() if one.rows}


def send(at: Entity, run: ComparedRun, what: str, extent: Range) -> None:
    """Log the maps of one kind."""
    for where, sheet in sheets(run, what, extent).items():
        sheet.send(at / where)


def send_bodies(at: Entity, run: ComparedRun) -> None:
    """Log the heat of what is not a place, over time."""
    for name, heat, words in _bodies(run):
        names = [f"{words}{body} [W]" for body in heat.bodies]
        colour = paths.CROSS_VALIDATED if name == BROUGHT else paths.COMPARED_AS[name]
        (at / BODIES / name).lines(names, [colour] * len(names), 1.5)
        (at / BODIES / name).curves(heat.time_s, heat.W)


def _bodies(run: ComparedRun) -> Iterator[tuple[str, HeatMap, str]]:
    for side, one in run.named.items():
        if one.heat.bodies:
            yield side, one.heat, run.said(side)
        if one.brought is not None and one.brought.W.any():
            yield BROUGHT, one.brought, f"{_by(run)} into "


def bodies(run: ComparedRun) -> Range:
    """Range of the heat of what is not a place."""
    return rounded(widened(extent_of(*(heat.W for _, heat, _ in _bodies(run))), 1.0))
