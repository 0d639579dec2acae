"""Errors as bars from 0: a row for each step or channel, in it a bar for each series, with its values beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr

from estimator.record import Array
from viz.drawing import paths
from viz.drawing.axes import words
from viz.drawing.frame import LINE, NAMES, ROW, WIDTH, Frame
from viz.drawing.scale import Colours, extent_of, rounded, ticks_of

LETTER = 14.0  # view units in a name, about
FILLED = 0.8  # of a row


@dataclass(frozen=True)
class Series:
    """Values (rows,) of one colour; NaN where there is none."""

    name: str
    values: Array
    colour: paths.Colour


@dataclass(frozen=True)
class Bars:
    """One figure; the unit stands in its title."""

    title: str
    rows: Sequence[str]
    series: Sequence[Series]

    @property
    def end(self) -> float:
        """Where the scale ends, in the unit of the values."""
        return rounded((0.0, 1.35 * max(extent_of(*(each.values for each in self.series))[1], 1e-9)), 6)[1]

    @property
    def known(self) -> bool:
        """Whether there is anything to show."""
        return any(np.isfinite(each.values).any() for each in self.series)

    @property
    def frame(self) -> Frame:
        """The picture, with room for the names of its rows."""
        return Frame(WIDTH, self.rows, max(NAMES, LETTER * (3 + max(map(len, self.rows)))))


def at(tab: str, i: int) -> str:
    """Where figure i of a tab is."""
    return f"{paths.BARS}/{paths.root(tab)}/{i}"


def send(rec: rr.RecordingStream, path: str, bars: Bars) -> None:
    """Log one figure, once."""
    frame, end = bars.frame, bars.end
    ticks = ticks_of((0.0, end))
    across = WIDTH * ticks / end
    frame.draw(rec, path, _pixels(bars), across, [f"{tick:g}" for tick in ticks])
    upright = [np.array([[x, 0.0], [x, frame.height]]) for x in across]
    grid = rr.LineStrips2D(upright, radii=rr.Radius.ui_points(0.5), colors=paths.GRID, draw_order=5.0)
    rec.log(f"{path}/grid", grid, static=True)
    _values(rec, f"{path}/values", bars)
    names = [each.name for each in bars.series]
    xs = WIDTH * (np.arange(len(names)) + 0.5) / len(names)
    places = np.stack([xs, np.full(len(xs), -1.8 * LINE)], axis=-1)
    words(rec, f"{path}/key", places, names, [each.colour for each in bars.series])


def _edges(count: int, i: int) -> tuple[int, int]:
    """First and last pixel of bar i of a row, from the row's top."""
    height = FILLED * ROW / count
    top = (1.0 - FILLED) / 2 * ROW + i * height
    return round(top), round(top + height) - 2


def _pixels(bars: Bars) -> Colours:
    """Pixels (height, width, 3)."""
    pixels = np.full((bars.frame.height, WIDTH, 3), paths.BACKGROUND, dtype=np.uint8)
    for i, each in enumerate(bars.series):
        top, bottom = _edges(len(bars.series), i)
        for row in np.flatnonzero(np.isfinite(each.values)):
            right = round(WIDTH * each.values[row] / bars.end)
            pixels[row * ROW + top : row * ROW + bottom, : right + 1] = each.colour
    return pixels


def _values(rec: rr.RecordingStream, path: str, bars: Bars) -> None:
    """The values of each row, in the order of the series, right of its longest bar."""
    values = np.stack([each.values for each in bars.series])
    rows = np.flatnonzero(np.isfinite(values).any(axis=0))
    texts = [" / ".join(f"{value:.3f}" for value in values[:, row] if np.isfinite(value)) for row in rows]
    room = 0.5 * LETTER * np.array([len(text) + 1.5 for text in texts])
    right = WIDTH * np.nanmax(values[:, rows], axis=0) / bars.end + room
    words(rec, path, np.stack([right, (rows + 0.5) * ROW - 0.56 * LINE], axis=-1), texts)
