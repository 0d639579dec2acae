"""Curves of two models on one recording: every thermometer, the elongation, and what of the displacement is missed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import rerun as rr

from estimator.record import Array
from viz.drawing import paths, series
from viz.drawing.scale import Range, extent_of, minutes, rounded, widened

if TYPE_CHECKING:
    from viz.comparison.compared import Compared, Side

MEAN_S = 10.0
COLOURS = {"before": paths.BEFORE, "after": paths.AFTER}
PALE = 0.55  # how bright the filter's curve is beside the model's


def sides_of(run: Compared) -> dict[str, Side]:
    """The models by "before" and "after"."""
    return dict(zip(paths.SIDES, run.sides, strict=False))


def said(side: str, run: Compared) -> str:
    """How a legend begins: nothing to tell apart where there is one model."""
    return f"{side}, " if len(run.sides) > 1 else ""


def send(rec: rr.RecordingStream, run: Compared) -> None:
    """Log the curves of one run."""
    root = paths.root(run.name)
    for i in run.thermometers:
        _temperatures(rec, root, run, int(i))
    if run.rig.screw is not None:
        _elongation(rec, root, run)
    if len(run.lengths):
        _misfit(rec, root, run)


def _temperatures(rec: rr.RecordingStream, root: str, run: Compared, i: int) -> None:
    name = run.rig.names[i]
    at = paths.compared(root, "temperature", name)
    series.lines(rec, f"{at}/measured", ["measured [°C]"], [paths.REFERENCE], 1.0)
    _means(rec, f"{at}/measured", run.time_s, run.measured[:, [i]])
    for side, one in sides_of(run).items():
        names = [f"{said(side, run)}open-loop [°C]", f"{said(side, run)}filter [°C]"]
        series.lines(rec, f"{at}/{side}", names, [COLOURS[side], _pale(COLOURS[side])], 2.0)
        _means(rec, f"{at}/{side}", run.time_s, np.stack([one.open_loop[:, i], one.predicted[:, i]], axis=-1))


def _elongation(rec: rr.RecordingStream, root: str, run: Compared) -> None:
    at = paths.compared(root, "elongation")
    for side, one in sides_of(run).items():
        series.band(rec, f"{at}/{side}/filter", f"{said(side, run)}filter ±2 sd", _pale(COLOURS[side]), 1.5)
        middle, means = minutes(run.time_s, np.stack([one.elongation_um, one.sigma_um], axis=-1), MEAN_S)
        series.send_band(rec, f"{at}/{side}/filter", middle + MEAN_S / 2, means[:, 0], means[:, 1])
        series.lines(rec, f"{at}/{side}/open_loop", [f"{said(side, run)}open-loop [µm]"], [COLOURS[side]], 2.0)
        _means(rec, f"{at}/{side}/open_loop", run.time_s, one.open_loop_um[:, None])
    series.dots(rec, f"{at}/readings", "readings [µm]", paths.READING, 3.0)
    shown = series.spaced(run.time_s, run.readings_um, extent_of(run.time_s), elongation(run))
    series.send_known(rec, f"{at}/readings", run.time_s[shown], run.readings_um[shown])


def _misfit(rec: rr.RecordingStream, root: str, run: Compared) -> None:
    at = paths.compared(root, "displacement")
    for side, one in sides_of(run).items():
        names = [f"{said(side, run)}{run.rig.names[i]} − open-loop [µm]" for i in run.lengths]
        series.dots(rec, f"{at}/{side}", names, COLOURS[side], 2.0)
        _means(rec, f"{at}/{side}", one.misfit_time_s, one.misfit[:, run.lengths])


def elongation(run: Compared) -> Range:
    """Range of the lengths."""
    lengths = [length for one in run.sides for length in (one.elongation_um, one.open_loop_um)]
    return rounded(widened(extent_of(run.readings_um, *lengths), 1.0))


def misfit(run: Compared) -> Range:
    """Range of what of the displacement is missed."""
    return rounded(widened(extent_of(*(one.misfit[:, run.lengths] for one in run.sides)), 1.0))


def temperatures(run: Compared, i: int) -> Range:
    """Range of one thermometer and what models say of it."""
    return rounded(widened(extent_of(run.measured[:, i], *(one.open_loop[:, i] for one in run.sides)), 1.0))


def _means(rec: rr.RecordingStream, at: str, time_s: Array, values: Array) -> None:
    begins, means = minutes(time_s, values, MEAN_S)
    known = np.isfinite(means).any(axis=1)
    series.send(rec, at, begins[known] + MEAN_S / 2, means[known])


def _pale(colour: paths.Colour) -> list[int]:
    return [round(PALE * part) for part in colour]
