"""Bars: a row for each step or channel, in it a bar for each series, with the values beside it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import rerun as rr
from numpy.typing import ArrayLike

from estimator.record import Array
from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.drawing.frames import LINE, NAMES, ROW, WIDTH, Frame, places
from viz.drawing.scale import Colours, extent_of, rounded, ticks_of

LETTER = 14.0  # view units in a name, about
FILLED = 0.8  # of a row
TICKS = np.array([m * 10.0**power for power in range(-3, 4) for m in (1, 2, 5)])  # of NIS


@dataclass(frozen=True)
class BarSeries:
    """Values (rows,) of one colour; NaN where there is none."""

    name: str
    values: Array
    colour: paths.Colour


@dataclass(frozen=True)
class Bars:
    """One figure of errors, whose bars go from 0 to the right; the unit stands in its title.

    line  height of a line of text in view units: more of them where many rows share a view
    """

    title: str
    rows: Sequence[str]
    series: Sequence[BarSeries]
    width: int = WIDTH
    line: float = LINE
    right: ClassVar[float] = 0.0  # where bars begin

    @property
    def values(self) -> Array:
        """All values, (series, rows)."""
        return np.stack([each.values for each in self.series])

    @property
    def end(self) -> float:
        """Where the scale ends."""
        return rounded((0.0, 1.02 * max(extent_of(self.values)[1], 1e-9)), 6)[1]

    @property
    def ticks(self) -> Array:
        """Where the scale has its lines."""
        return ticks_of((0.0, self.end))

    def across(self, values: ArrayLike) -> Array:
        """Where values stand, pixels from the left."""
        return self.width * np.asarray(values) / self.end

    @property
    def legend(self) -> list[tuple[str, paths.Colour]]:
        """What the colours mean."""
        return [(each.name, each.colour) for each in self.series]

    @property
    def texts(self) -> list[str]:
        """The values of each row in words."""
        return [" / ".join(f"{value:.3f}" for value in row if np.isfinite(value)) for row in self.values.T]

    @property
    def frame(self) -> Frame:
        """The picture, with room for the names of its rows and for their values."""
        names, values = (LETTER * self.line / LINE * (3 + max(map(len, some))) for some in (self.rows, self.texts))
        return Frame(self.width, self.rows, max(NAMES, names), self.line, max(0.3 * NAMES, values))


class NisBars(Bars):
    """One figure of NIS, whose bars go from 1, where it belongs, on a log scale: half is as far off as twice."""

    right = 1.0

    @property
    def ticks(self) -> Array:
        """Where the scale has its lines, the first and the last at its ends."""
        lo, hi = extent_of(np.clip(self.values, TICKS[0], TICKS[-1]), np.array([0.5, 2.0]))
        first, last = np.flatnonzero(lo * 1.001 >= TICKS)[-1], np.flatnonzero(hi <= 1.001 * TICKS)[0]
        return TICKS[first : last + 1]

    def across(self, values: ArrayLike) -> Array:
        """Where values stand, pixels from the left."""
        lo, hi = self.ticks[[0, -1]]
        return np.asarray(self.width * np.log(np.clip(values, lo, hi) / lo) / np.log(hi / lo))

    @property
    def legend(self) -> list[tuple[str, paths.Colour]]:
        """What the colours mean."""
        return [*super().legend, ("1: the noise is right", paths.READING)]


def send(at: Entity, bars: Bars, since_s: float | None = None) -> None:
    """Log one figure, once or from a time on."""
    frame, ticks = bars.frame, bars.ticks
    frame.draw(at, _pixels(bars), bars.across(ticks), [f"{tick:g}" for tick in ticks], since_s)
    lines = {"grid": (ticks, paths.GRID)} | ({"right": (np.ones(1), paths.READING)} if bars.right else {})
    for name, (values, colour) in lines.items():
        upright = [places([x, x], [0, frame.height]) for x in bars.across(values)]
        strips = rr.LineStrips2D(upright, radii=rr.Radius.ui_points(0.5), colors=colour, draw_order=5.0)
        (at / name).log(strips, since_s)
    _values(at / "values", bars, since_s)
    names, colours = zip(*bars.legend, strict=True)
    letters = np.array([len(name) + 4 for name in names])
    shares = (letters.cumsum() - letters / 2) / letters.sum()  # each with room for its letters
    left, right = 0.0, float(bars.width)
    if letters.sum() * LETTER * bars.line / LINE > bars.width:
        left, right = frame.bounds[0][0] + 0.5 * bars.line, right + 0.5 * frame.beyond
    (at / "key").words(places(left + (right - left) * shares, -1.8 * bars.line), names, colours, since_s)


def _edges(count: int, i: int) -> tuple[int, int]:
    """First and last pixel of bar i of a row, from the row's top."""
    height = FILLED * ROW / count
    top = (1.0 - FILLED) / 2 * ROW + i * height
    return round(top), round(top + height) - 2


def _pixels(bars: Bars) -> Colours:
    """Pixels (height, width, 3)."""
    pixels = np.full((bars.frame.height, bars.width, 3), paths.BACKGROUND, dtype=np.uint8)
    for i, each in enumerate(bars.series):
        top, bottom = _edges(len(bars.series), i)
        for row in np.flatnonzero(np.isfinite(each.values)):
            left, right = np.sort(bars.across([bars.right, each.values[row]])).round().astype(int)
            pixels[row * ROW + top : row * ROW + bottom, left : right + 1] = each.colour
    return pixels


def _values(at: Entity, bars: Bars, since_s: float | None) -> None:
    """The values of each row, in the order of the series, right of all bars."""
    rows = np.flatnonzero(np.isfinite(bars.values).any(axis=0))
    middle = bars.width + 0.5 * bars.frame.beyond
    at.words(places(middle, (rows + 0.5) * ROW - 0.56 * bars.line), [bars.texts[row] for row in rows], since_s=since_s)
