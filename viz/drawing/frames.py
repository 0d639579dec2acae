"""Frames drawn by hand, for a 2D view has no axes of its own: around curves and points, and around pictures.

Of axes a point (x, y) in the data's units stands at (x * x_unit, -y * y_unit) of the view, whose y runs downwards. A
label hangs below its anchor, so those of y are lifted by half a line.

Axes whose ranges grow are drawn anew from `since_s` on.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import rerun as rr
from numpy.typing import ArrayLike

from estimator.record import Array
from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.drawing.scale import DIVERGING, Colours, Range, coloured, ticks_of

ROW, WIDTH = 50, 900  # pixels: height of a row, about the width of a picture
LINE = 30.0  # height of a line of text, which the viewer draws in points whatever the zoom
NAMES = 165.0  # room left of the picture


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
        return places(np.asarray(x, dtype=float) * self.x_unit, self.down - np.asarray(y, dtype=float) * self.y_unit)

    def _shifted(self, x: ArrayLike, y: ArrayLike, widths: float, lines: float) -> Array:
        """Places (..., 2) moved to the right by a share of the width and down by so many lines of text."""
        return self.place(x, y) + np.array([widths * self.width, lines * self.line])

    def grounded(self) -> "Axes":
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
        at: Entity,
        x_title: str,
        y_title: str = "",
        y_unit: str = "",
        x_pieces: int = 7,
        since_s: float | None = None,
    ) -> None:
        """Log grid, tick labels and titles."""
        xs, ys = ticks_of(self.x, x_pieces), ticks_of(self.y, 7)
        upright = [self.place([x, x], self.y) for x in {*xs, *self.x}]
        level = [self.place(self.x, [y, y]) for y in {*ys, *self.y}]
        grid = rr.LineStrips2D(upright + level, radii=rr.Radius.ui_points(0.5), colors=paths.GRID, draw_order=-10.0)
        (at / "grid").log(grid, since_s)
        left = self._shifted(self.x[0], ys, -0.05 if y_unit else -0.035, -0.56)
        labels = {
            "x": (self._shifted(xs, self.y[0], 0.0, 0.15), [f"{x:g}" for x in xs]),
            "y": (left, [f"{y:g}{y_unit}" for y in ys]),
            "x_title": (self._shifted([sum(self.x) / 2], self.y[0], 0.0, 1.5), [x_title]),
        }
        if y_title:
            labels["y_title"] = self._shifted([self.x[0]], self.y[1], 0.05, -1.8), [y_title]
        for name, (places, texts) in labels.items():
            (at / name).words(places, texts, since_s=since_s)

    def key(self, at: Entity, entries: Sequence[tuple[str, paths.Colour]]) -> None:
        """Log coloured words in a row above the frame, each with room for its letters, once."""
        left, top = self.place(self.x[0], self.y[1])
        room = np.array([len(name) + 4.0 for name, _ in entries])
        xs = left + self.width * (room.cumsum() - room / 2) / room.sum()
        rows = np.stack([xs, np.full(len(xs), top - 1.8 * self.line)], axis=-1)
        at.words(rows, [name for name, _ in entries], [colour for _, colour in entries])


@dataclass(frozen=True)
class Frame:
    """A picture with a row for each name, the first at the top; units are its pixels, its top left corner is (0, 0)."""

    width: int
    names: Sequence[str]
    room: float = NAMES
    line: float = LINE
    beyond: float = 0.3 * NAMES  # room right of it

    @property
    def height(self) -> int:
        """Pixels."""
        return ROW * len(self.names)

    @property
    def bounds(self) -> tuple[Range, Range]:
        """What a view must show: the picture, names at its left, a row of words above and two below."""
        return (-self.room, self.width + self.beyond), (-2.6 * self.line, self.height + 3.2 * self.line)

    def draw(
        self, at: Entity, pixels: Colours, x: ArrayLike, texts: Sequence[str], since_s: float | None = None
    ) -> None:
        """Log the picture, the names of its rows, and the texts below it at x, once or from a time on."""
        (at / "picture").picture(pixels, since_s)
        middles = (np.arange(len(self.names)) + 0.5) * ROW - 0.56 * self.line
        (at / "channels").words(places(-0.5 * self.room, middles), self.names, since_s=since_s)
        (at / "x").words(places(x, self.height + 0.2 * self.line), texts, since_s=since_s)


def places(x: ArrayLike, y: ArrayLike) -> Array:
    return np.stack(np.broadcast_arrays(np.asarray(x, dtype=float), y), axis=-1)


def colour_bar(at: Entity, extent: Range, labels: Sequence[str]) -> None:
    """Log what the colours of a map mean: an upright bar over its range, with labels evenly beside it."""
    n, width = 64, 6.0
    shades = coloured(np.linspace(*extent, n), extent, DIVERGING)
    (at / "bar").picture(np.repeat(shades[::-1, None, :3], int(width), axis=1))
    ys = np.linspace(n, 0, len(labels)) - 0.03 * n
    (at / "labels").words(np.stack([np.full(len(ys), 3.6 * width), ys], axis=-1), labels)
