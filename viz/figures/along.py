"""Curves over a place, each with a band of two sd, in a frame drawn by hand; the nut's travel and bearings below."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr

from estimator.record import Array
from estimator.rig import Rig
from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.drawing.frames import Axes
from viz.drawing.profile import bearings_mm, comb, send_bars
from viz.drawing.scale import Range, extent_of, rounded, widened

LINE = 22.0  # points, height of a label
STROKES = 160  # in a band
PALE = 0.35  # of a curve's colour in its band


@dataclass(frozen=True)
class Curve:
    """One curve: mean and sd (n,) at places x (n,), mm."""

    name: str
    colour: paths.Colour
    x_mm: Array
    mean: Array
    sd: Array

    @property
    def ends(self) -> Array:
        """What an axis must hold."""
        return np.stack([self.mean - 2 * self.sd, self.mean + 2 * self.sd])


def axes_of(x: Range, curves: Sequence[Curve], view: Range, least: float) -> Axes:
    """The frame in a `view` so many points wide and high; the upright axis at least `least` long, with 0 in it."""
    y = rounded(widened(extent_of(np.zeros(1), *(curve.ends for curve in curves)), least))
    return Axes(x, y, view[0] / 1.2, view[1] - 6.0 * LINE, LINE)


def send(at: Entity, axes: Axes, rig: Rig, curves: Sequence[Curve], travel: Range | None, title: str) -> None:
    """Log frame and curves, once; `title` says what x is."""
    axes.draw(at / "axes", title, x_pieces=10)
    marks = (("nut's travel", paths.NUT), ("bearings", paths.BOUND))
    drawn = [mark for mark, there in zip(marks, (travel, rig.supports), strict=True) if there]
    axes.key(at / "key", [*((f"{curve.name} ±2 sd", curve.colour) for curve in curves), *drawn])
    send_bars(at / "bearings", axes, bearings_mm(rig), paths.BOUND)
    send_bars(at / "travel", axes, [travel] if travel else [], paths.NUT)
    _line(at / "zero", axes, np.array(axes.x), np.zeros(2), paths.BOUND, 0.7)
    for i, curve in enumerate(curves):
        shift = (axes.x[1] - axes.x[0]) / STROKES * i / len(curves)  # bands that overlap are both seen
        x = np.arange(curve.x_mm[0] + shift, curve.x_mm[-1], (axes.x[1] - axes.x[0]) / STROKES)
        low, high = (np.interp(x, curve.x_mm, end) for end in curve.ends)
        pale = tuple(round(PALE * part + (1 - PALE) * dark) for part, dark in zip(curve.colour, paths.BACKGROUND))
        _line(at / "band" / str(i), axes, np.repeat(x, 2), comb(low[None], high[None])[0], pale, 0.8)
        _line(at / "curve" / str(i), axes, curve.x_mm, curve.mean, curve.colour, 1.6)


def _line(at: Entity, axes: Axes, x: Array, y: Array, colour: Sequence[int], radius: float) -> None:
    strip = axes.place(x, y).astype(np.float32)
    at.log(rr.LineStrips2D([strip], radii=rr.Radius.ui_points(radius), colors=colour, draw_order=radius))
