"""Ranges of live views: nobody knows what will come, so they grow with it.

A range that grows takes a share more than it must, so that axes are drawn anew a few times in a run, not all the time.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.record import Array
from viz.drawing.entity import Entity
from viz.drawing.scale import Range, extent_of, rounded, step_of, widened
from viz.live.repeat import Repeated

AHEAD = 0.2  # of the range, taken more where it grows
PIECES = 10  # ends are whole ticks of about so many


class Growing:
    """A range that holds all values so far, `least` wide at first, its ends rounded outwards."""

    def __init__(self, least: float) -> None:
        self._least = least
        self._extent: Range | None = None

    def hold(self, values: Iterable[Array]) -> Range | None:
        """Take values in, some of which may be unknown; returns the range, None while nothing is known."""
        known = np.concatenate([np.ravel(each) for each in values])
        known = known[np.isfinite(known)]
        if len(known) and self._extent is None:
            self._extent = rounded(widened(extent_of(known), self._least), PIECES)
        elif len(known) and self._extent is not None:
            (lo, hi), (low, high) = self._extent, extent_of(known)
            more = AHEAD * (max(hi, high) - min(lo, low))
            if low < lo or high > hi:
                self._extent = rounded((low - more if low < lo else lo, high + more if high > hi else hi), PIECES)
        return self._extent


@dataclass(frozen=True)
class Decades:
    """A fixed scale for the colours of a map: what is drawn already has its colours, so its range cannot grow.

    Within +-finest the colour is that of 0; each of the two decades above has half of the way to the end.
    """

    finest: float

    @classmethod
    def of(cls, sd: Array) -> "Decades":
        """For means of values that scatter by `sd`, some of which may be unknown."""
        return cls(step_of(float(np.nanmedian(sd)) / 10, 1))

    def shares(self, values: Array) -> Array:
        """Where values stand on the scale, -1 ... 1 and beyond."""
        return np.sign(values) * np.log10(np.maximum(np.abs(values), self.finest) / self.finest) / 2

    @property
    def labels(self) -> list[str]:
        """What stands at equal distances along the scale, lowest first."""
        small, large = (f"{self.finest * ratio:g} K" for ratio in (10.0, 100.0))
        return [f"-{large}", f"-{small}", f"±{self.finest:g} K", f"+{small}", f"+{large}"]


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
