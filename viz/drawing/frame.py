"""A frame for figures that stand still: rows of names at its left, lines across."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr
from numpy.typing import ArrayLike

from estimator.record import Array
from viz.drawing.axes import words
from viz.drawing.scale import Colours, Range

ROW, WIDTH = 50, 900  # pixels: height of a channel, about the width of a picture
LINE = 30.0  # height of a line of text, which the viewer draws in points whatever the zoom
NAMES = 165.0  # room left of the picture


@dataclass(frozen=True)
class Frame:
    """A picture with a row for each channel, the first at the top."""

    width: int
    channels: Sequence[str]
    room: float = NAMES
    line: float = LINE

    @property
    def height(self) -> int:
        """Pixels."""
        return ROW * len(self.channels)

    @property
    def bounds(self) -> tuple[Range, Range]:
        """What a view must show: the picture, names at its left, a row of words above and two below."""
        return (-self.room, self.width + 0.3 * NAMES), (-2.6 * self.line, self.height + 3.2 * self.line)

    def draw(self, rec: rr.RecordingStream, at: str, pixels: Colours, x: ArrayLike, texts: Sequence[str]) -> None:
        """Log the picture, the names of its rows, and the texts below it at x."""
        rec.log(f"{at}/picture", rr.Image(np.ascontiguousarray(pixels), magnification_filter="Nearest"), static=True)
        middles = (np.arange(len(self.channels)) + 0.5) * ROW - 0.56 * self.line
        words(rec, f"{at}/channels", places(-0.5 * self.room, middles), self.channels)
        words(rec, f"{at}/x", places(x, self.height + 0.2 * self.line), texts)


def places(x: ArrayLike, y: ArrayLike) -> Array:
    return np.stack(np.broadcast_arrays(np.asarray(x, dtype=float), y), axis=-1)
