"""A map: rows over time as colours, with the name of each row, a time axis and the bar of its colours in one view.

Units of the view are points of the window it is laid out for: the viewer draws labels in points whatever the zoom.
Names stand in two columns where rows are lower than a label.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr

from estimator.record import Array
from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.drawing.scale import DIVERGING, MINUTE_S, Anchors, Colours, Range, coloured, minutes, ticks_of

LABEL = 22.0  # height of a label, points
LETTER, MARGIN = 7.5, 14.0  # width of a letter, and of what is around the letters of a label
GAP, BAR = 16.0, 14.0  # right of the picture: nothing, then the bar of colours
MOST_COLUMNS = 400  # of a map: more are narrower than a pixel of a small window
HOURS_S = 5 * 3600.0  # a run as long as that is told in hours
SHADES = 64


@dataclass(frozen=True)
class Map:
    """Values (n, rows) of columns that begin at begins_s (n,), with names of the rows, the first at the top.

    ticks, texts   where below the map, in columns, what stands;  title: what that is
    """

    rows: Sequence[str]
    begins_s: Array
    values: Array
    ticks: Array
    texts: Sequence[str]
    title: str

    @classmethod
    def over_time(cls, rows: Sequence[str], begins_s: Array, values: Array) -> "Map":
        """Columns of one length, with their times below."""
        width_s = float(begins_s[1] - begins_s[0]) if len(begins_s) > 1 else MINUTE_S
        unit, unit_s = ("h", 3600.0) if len(begins_s) * width_s > HOURS_S else ("min", 60.0)
        ticks = ticks_of((0.0, len(begins_s) * width_s / unit_s), 6)
        title = f"time [{unit}], mean of {width_s / MINUTE_S:g} min"
        return cls(rows, begins_s, values, ticks * unit_s / width_s, [f"{tick:g}" for tick in ticks], title)


@dataclass(frozen=True)
class Sheet:
    """A map as it is drawn: the range of its colours with their unit, and width and height of its view in points."""

    map: Map
    extent: Range
    unit: str
    view: Range
    anchors: Anchors = DIVERGING

    @property
    def height(self) -> float:
        """Of the picture: half a label is above it, the times and what they are below."""
        return self.view[1] - 2.7 * LABEL

    @property
    def width(self) -> float:
        """Of the picture."""
        return self.view[0] - self.columns * self._name - GAP - BAR - self._label

    @property
    def columns(self) -> int:
        """Of names."""
        return 1 if self.height / len(self.map.rows) >= LABEL else 2

    @property
    def _name(self) -> float:
        return _wide(max(self.map.rows, key=len))

    @property
    def _label(self) -> float:
        return _wide(max(self._labels, key=len))

    @property
    def _labels(self) -> list[str]:
        ends = np.linspace(*self.extent, 5)
        sign = "+" if self.extent[0] < 0.0 else ""
        return [f"{value:{sign if value else ''}g} {self.unit}".rstrip() for value in ends]

    @property
    def bounds(self) -> tuple[Range, Range]:
        """What a view must show: the picture, names at its left, the bar of colours at its right, times below."""
        left = -self.columns * self._name
        return (left, left + self.view[0]), (-LABEL / 2, self.height + 2.2 * LABEL)

    def send(self, at: Entity) -> None:
        """Log it, once, and a line that goes with the cursor."""
        shades = coloured(self.map.values.T, self.extent, self.anchors)[..., :3]
        self._picture(at / "picture", shades, (0.0, self.width))
        bar = coloured(np.linspace(*self.extent[::-1], SHADES), self.extent, self.anchors)[:, None, :3]
        self._picture(at / "bar", bar, (self.width + GAP, BAR))
        middle = self.width + GAP + BAR + self._label / 2
        self._words(at / "bar_labels", np.full(5, middle), np.linspace(self.height, 0.0, 5), self._labels)
        rows = np.arange(len(self.map.rows))
        x = -self._name * (0.5 + rows % self.columns)
        self._words(at / "channels", x, (rows + 0.5) * self.height / len(rows), self.map.rows)
        across = self.width * np.asarray(self.map.ticks) / len(self.map.values)
        self._words(at / "x", across, np.full(len(across), self.height + 0.7 * LABEL), self.map.texts)
        self._words(at / "title", [self.width / 2], [self.height + 1.7 * LABEL], [self.map.title])
        self._cursor(at / "now")

    def _picture(self, at: Entity, shades: Colours, across: Range) -> None:
        """A pixel for each value, stretched to a place and a width."""
        (left, width), (high, wide) = across, shades.shape[:2]
        at.picture(shades)
        at.log(rr.Transform3D(translation=[left, 0.0, 0.0], scale=[width / wide, self.height / high, 1.0]))

    def _cursor(self, at: Entity) -> None:
        n = len(self.map.begins_s)  # none of a map over something else
        x = np.repeat((np.arange(n) + 0.5) * self.width / max(n, 1), 2)
        strips = np.stack([x, np.tile([0.0, self.height], n)], axis=-1).reshape(n, 2, 2).astype(np.float32)
        at.log(rr.LineStrips2D.from_fields(radii=rr.Radius.ui_points(0.5), colors=paths.TEXT, draw_order=20.0))
        at.rows(self.map.begins_s, rr.LineStrips2D.columns(strips=strips))

    def _words(self, at: Entity, x: Array | Sequence[float], y: Array | Sequence[float], texts: Sequence[str]) -> None:
        """Labels whose middles are at x, y: the viewer hangs them below."""
        at.words(np.stack([x, np.asarray(y) - 0.5 * LABEL], axis=-1), texts)


def means(time_s: Array, values: Array) -> tuple[Array, Array]:
    """Means over minutes, over more of them where a run has more than a map has columns: begins (n,) s, (n, ...)."""
    several = np.ceil((time_s[-1] - time_s[0]) / MINUTE_S / MOST_COLUMNS + 1e-9)
    return minutes(time_s, values, float(MINUTE_S * several))


def _wide(text: str) -> float:
    return LETTER * len(text) + MARGIN
