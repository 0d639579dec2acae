"""Axes drawn by hand: a 2D view has none of its own.

A point (x, y) in the data's units stands at (x * x_unit, -y * y_unit) of the view, whose y runs downwards. A label
hangs below its anchor, so those of y are lifted by half a line.

What is not `static` holds from the time that the stream has been given: a frame whose ranges grow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import rerun as rr
from numpy.typing import ArrayLike

from estimator.record import Array
from viz.drawing import paths
from viz.drawing.scale import Colours, Range, ticks_of


@dataclass(frozen=True)
class Axes:
    """A frame `width` by `height` over the ranges `x` and `y` in the data's units; all else in view units."""

    x: Range
    y: Range
    width: float
    height: float
    line: float  # height of a line of text, which the viewer draws in points whatever the zoom
    down: float = 0.0  # how much lower the frame stands

    @property
    def x_unit(self) -> float:
        """View units per unit of x."""
        return self.width / (self.x[1] - self.x[0])

    @property
    def y_unit(self) -> float:
        """View units per unit of y."""
        return self.height / (self.y[1] - self.y[0])

    def place(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Where points stand in the view, (..., 2)."""
        x, y = np.broadcast_arrays(x, y)
        return np.stack(
            [np.asarray(x, dtype=float) * self.x_unit, self.down - np.asarray(y, dtype=float) * self.y_unit], axis=-1
        )

    def _shifted(self, x: ArrayLike, y: ArrayLike, widths: float, lines: float) -> Array:
        """Places (..., 2) moved to the right by a share of the width and down by so many lines of text."""
        return self.place(x, y) + np.array([widths * self.width, lines * self.line])

    def grounded(self) -> Axes:
        """The same frame with its bottom at 0 of the view, whatever y is there."""
        return replace(self, down=self.y[0] * self.y_unit)

    @property
    def bounds(self) -> tuple[Range, Range]:
        """What a view must show: the frame and its labels."""
        (left, bottom), (right, top) = self.place(self.x[0], self.y[0]), self.place(self.x[1], self.y[1])
        x = left - 0.12 * self.width, right + 0.05 * self.width
        return x, (top - 2.6 * self.line, bottom + 3.2 * self.line)

    def draw(
        self,
        rec: rr.RecordingStream,
        at: str,
        x_title: str,
        y_title: str = "",
        y_unit: str = "",
        x_pieces: int = 7,
        static: bool = True,
    ) -> None:
        """Log grid, tick labels and titles under `at`."""
        xs, ys = ticks_of(self.x, x_pieces), ticks_of(self.y, 7)
        upright = [self.place([x, x], self.y) for x in {*xs, *self.x}]
        level = [self.place(self.x, [y, y]) for y in {*ys, *self.y}]
        grid = rr.LineStrips2D(upright + level, radii=rr.Radius.ui_points(0.5), colors=paths.GRID, draw_order=-10.0)
        rec.log(f"{at}/grid", grid, static=static)
        left = self._shifted(self.x[0], ys, -0.05 if y_unit else -0.035, -0.56)
        labels = {
            "x": (self._shifted(xs, self.y[0], 0.0, 0.15), [f"{x:g}" for x in xs]),
            "y": (left, [f"{y:g}{y_unit}" for y in ys]),
            "x_title": (self._shifted([sum(self.x) / 2], self.y[0], 0.0, 1.5), [x_title]),
        }
        if y_title:
            labels["y_title"] = self._shifted([self.x[0]], self.y[1], 0.05, -1.8), [y_title]
        for name, (places, texts) in labels.items():
            words(rec, f"{at}/{name}", places, texts, static=static)

    def key(self, rec: rr.RecordingStream, at: str, entries: Sequence[tuple[str, paths.Colour]]) -> None:
        """Log coloured words in a row above the frame, each with room for its letters, once."""
        left, top = self.place(self.x[0], self.y[1])
        room = np.array([len(name) + 4.0 for name, _ in entries])
        xs = left + self.width * (room.cumsum() - room / 2) / room.sum()
        rows = np.stack([xs, np.full(len(xs), top - 1.8 * self.line)], axis=-1)
        words(rec, at, rows, [name for name, _ in entries], [colour for _, colour in entries])


def words(
    rec: rr.RecordingStream,
    at: str,
    places: ArrayLike,
    texts: Sequence[str],
    colours: Sequence[paths.Colour] | None = None,
    static: bool = True,
) -> None:
    """Log labels at places (n, 2) in view units."""
    points = rr.Points2D(places, labels=list(texts), show_labels=True, radii=0.0, colors=colours or paths.TEXT)
    rec.log(at, points, static=static)


def colour_bar(rec: rr.RecordingStream, at: str, colours: Colours, labels: Sequence[str]) -> None:
    """Log an upright bar of colours (n, 4), lowest first, with labels spread evenly beside it, lowest first."""
    n, width = len(colours), 6.0
    image = np.repeat(np.asarray(colours)[::-1, None, :3], int(width), axis=1)
    rec.log(f"{at}/bar", rr.Image(np.ascontiguousarray(image), magnification_filter="Nearest"), static=True)
    ys = np.linspace(n, 0, len(labels)) - 0.03 * n
    words(rec, f"{at}/labels", np.stack([np.full(len(ys), 3.6 * width), ys], axis=-1), labels)
