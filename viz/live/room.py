"""Room around the curves of a live plot, so that noise does not fill it.

The viewer fits the values' axis to the rows that the window shows. A layout sent anew with another range would undo
what the user has arranged; two points without a size, sent now and then, hold the range open instead. They have name
and colour of a curve, so that the legend shows them as one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from estimator.record import Array
from viz.drawing.entity import Entity
from viz.drawing.scale import Range
from viz.live.repeat import Repeated
from viz.live.scale import Growing


class Room:
    """The range of one plot, at least `least` wide, that holds all its values so far; sent again every `every_s` s."""

    def __init__(self, plot: Entity, name: str, colour: Sequence[int], least: float, every_s: float) -> None:
        self._points, self._range, self._sent = plot / "room", Growing(least), Repeated[Range](every_s)
        self._points.dots([name, name], colour, 0.0)

    def hold(self, time_s: float, values: Iterable[Array]) -> Range | None:
        """Take values of a batch that ends at `time_s`, some of which may be unknown; returns the range."""
        extent = self._range.hold(values)
        if extent is not None and self._sent.due(extent, time_s):
            self._points.curves(np.array([time_s]), np.array([extent]))
        return extent
