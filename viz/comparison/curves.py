"""Curves of two models on one recording: every thermometer, the elongation, and what of the displacement is missed."""

import numpy as np

from estimator.record import Array
from viz.comparison.compared import ComparedRun
from viz.drawing import paths, series
from viz.drawing.entity import Entity
from viz.drawing.scale import Range, extent_of, minutes, rounded, widened

MEAN_S = 10.0
PALE = 0.55  # how bright the filter's curve is beside the model's


def send(file: Entity, run: ComparedRun) -> None:
    """Log the curves of one run."""
    at = file / paths.compared(paths.root(run.name))
    for i in np.flatnonzero(run.rig.is_thermometer):
        _temperatures(at / "temperature" / paths.root(run.rig.names[i]), run, int(i))
    if run.rig.screw is not None:
        _elongation(at / "elongation", run)
    if not run.rig.is_thermometer.all():
        _misfit(at / "displacement", run)


def _temperatures(at: Entity, run: ComparedRun, i: int) -> None:
    (at / "measured").lines(["measured [°C]"], [paths.REFERENCE], 1.0)
    _means(at / "measured", run.time_s, run.measured[:, [i]])
    for side, one in run.named.items():
        names = [f"{run.said(side)}open-loop [°C]", f"{run.said(side)}filter [°C]"]
        (at / side).lines(names, [paths.COMPARED_AS[side], _pale(paths.COMPARED_AS[side])], 2.0)
        _means(at / side, run.time_s, np.stack([one.open_loop[:, i], one.predicted[:, i]], axis=-1))


def _elongation(at: Entity, run: ComparedRun) -> None:
    for side, one in run.named.items():
        said, colour = run.said(side), paths.COMPARED_AS[side]
        (at / side / "filter").band(f"{said}filter ±2 sd", _pale(colour), 1.5)
        begins, means = minutes(run.time_s, np.stack([one.elongation_um, one.sigma_um], axis=-1), MEAN_S)
        (at / side / "filter").banded(begins + MEAN_S / 2, *means.T)
        (at / side / "open_loop").lines([f"{said}open-loop [µm]"], [colour], 2.0)
        _means(at / side / "open_loop", run.time_s, one.open_loop_um[:, None])
    (at / "readings").dots("readings [µm]", paths.READING, 3.0)
    shown = series.spaced(run.time_s, run.readings_um, extent_of(run.time_s), elongation(run))
    (at / "readings").known(run.time_s[shown], run.readings_um[shown])


def _misfit(at: Entity, run: ComparedRun) -> None:
    lengths = ~run.rig.is_thermometer
    for side, one in run.named.items():
        names = [f"{run.said(side)}{run.rig.names[i]} − open-loop [µm]" for i in np.flatnonzero(lengths)]
        (at / side).dots(names, paths.COMPARED_AS[side], 2.0)
        _means(at / side, one.misfit_time_s, one.misfit[:, lengths])


def elongation(run: ComparedRun) -> Range:
    """Range of the lengths."""
    lengths = [length for one in run.sides for length in (one.elongation_um, one.open_loop_um)]
    return rounded(widened(extent_of(run.readings_um, *lengths), 1.0))


def misfit(run: ComparedRun) -> Range:
    """Range of what of the displacement is missed."""
    return rounded(widened(extent_of(*(one.misfit[:, ~run.rig.is_thermometer] for one in run.sides)), 1.0))


def temperatures(run: ComparedRun, i: int) -> Range:
    """Range of one thermometer and what models say of it."""
    return rounded(widened(extent_of(run.measured[:, i], *(one.open_loop[:, i] for one in run.sides)), 1.0))


def _means(at: Entity, time_s: Array, values: Array) -> None:
    begins, means = minutes(time_s, values, MEAN_S)
    known = np.isfinite(means).any(axis=1)
    at.curves(begins[known] + MEAN_S / 2, means[known])


def _pale(colour: paths.Colour) -> list[int]:
    return [round(PALE * part) for part in colour]
