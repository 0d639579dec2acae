"""How long the nut is at a place: where it conducts and keeps the air off, while friction heats by the angle turned."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Stay:
    """The coverage by time alone, waits at the ends of strokes included, of ticks in which it is another than by angle.

    These are few in a long recording: at rest, and on an even way, both are one.

    tick   (r,) rising     cover  (r, cells)
    """

    tick: NDArray[Any] = field(default_factory=lambda: np.empty(0, dtype=int))
    cover: NDArray[Any] = field(default_factory=lambda: np.empty((0, 0)))

    @classmethod
    def beside(cls, coverage: NDArray[Any], stay: NDArray[Any]) -> Stay:
        """Of ticks with a coverage by angle and by time, (K, cells) each, NaN where they are not known."""
        other = (stay != coverage).any(axis=1)
        return cls.of({k: stay[k] for k in np.flatnonzero(other).tolist() if np.isfinite(stay[k]).all()})

    @classmethod
    def of(cls, covers: Mapping[int, NDArray[Any]]) -> Stay:
        """By tick, in their order."""
        return cls(np.array(list(covers), dtype=int), np.array(list(covers.values()))) if covers else cls()

    def at(self, k: int) -> NDArray[Any] | None:
        """Of tick k, (cells,); None: as by angle."""
        i = int(np.searchsorted(self.tick, k))
        return self.cover[i] if i < len(self.tick) and self.tick[i] == k else None

    def rows(self, which: slice, ticks: int) -> Stay:
        """Some of so many ticks, in order."""
        if not len(self.tick):
            return self
        place = np.full(ticks, -1)
        place[which] = np.arange(len(place[which]))
        kept = place[self.tick] >= 0
        return Stay(place[self.tick[kept]], self.cover[kept])

    def each(self, change: Callable[[NDArray[Any]], NDArray[Any]]) -> Stay:
        """With another cover."""
        return Stay(self.tick, change(self.cover)) if len(self.tick) else self

    def over(self, coverage: NDArray[Any], ticks: NDArray[Any]) -> NDArray[Any]:
        """By time, of any ticks (...), (..., cells): the coverage (K, cells), where it is no other."""
        found = coverage[ticks]
        if (other := np.isin(ticks, self.tick)).any():
            found[other] = self.cover[np.searchsorted(self.tick, ticks[other])]
        return found
