"""The scans of a rig beside the stamps of its frames: how far they have come, and whether they went on over a jump."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from drivers.frames import Array, Index, Whole

GAP = 1.5  # ticks: a longer silence needs a decision
_TRUSTED = 60
_UNEVEN = 0.05  # share by which scans may differ in their number of frames


class Item(NamedTuple):
    """A frame, by number or as it is; its stamp, s; whether it closes a scan; the scan's number, -1 if unknown."""

    frame: Any
    stamp: float
    closes: bool
    scan: int


class Scans:
    """The last scan: its stamp and rig clock, s, and its number; frames since then, and in it.

    modulus  after how many scans their number starts again
    """

    def __init__(self, tick_s: float, modulus: int) -> None:
        self.since = 0
        self._tick_s, self._modulus = tick_s, modulus
        self._stamp, self._now, self._number = np.nan, 0.0, -1
        self._frames = 0

    @property
    def numbered(self) -> bool:
        """Whether the last one had a number."""
        return self._number >= 0

    def stands_still(self, stamp: float) -> bool:
        """Whether a scan with this stamp has the same as the one before, though frames came in between."""
        return stamp == self._stamp and self.since > 1

    def count(self, item: Item, now: float) -> None:
        """A frame is placed at `now` on the rig's clock, s."""
        self.since += 1
        if item.closes:
            self._stamp, self._now, self._number = item.stamp, now, item.scan
            self._frames, self.since = self.since, 0

    def stretch(self, stamps: Array, clock: Array, closing: Index, scan: Whole, start: int, stop: int) -> None:
        """The same for frames start ... stop; `closing` (m,) are the indices of those that close a scan."""
        last = int(np.searchsorted(closing, stop)) - 1
        if last < 0 or closing[last] < start:
            self.since += stop - start
            return
        index, before = int(closing[last]), int(closing[last - 1]) if last else -1
        self._frames = index - before if before >= start else self.since + index - start + 1
        self._stamp, self._now, self._number = float(stamps[index]), float(clock[index]), int(scan[index])
        self.since = stop - 1 - index

    def after_jump(self, waiting: Sequence[Item], jump: float) -> float | None:
        """Where the rig's clock stands at the first of these, s, if its scans went on over a jump of the stamps.

        None where they did not, or nothing is known of them.
        """
        closing = next((item for item in waiting if item.closes and item.scan >= 0), None)
        if closing is None or not self.numbered:
            return None
        scans = max((closing.scan - self._number) % self._modulus, 1)
        uncounted = (closing.stamp - self._stamp) / self._tick_s - scans
        again = min(uncounted % self._modulus, -uncounted % self._modulus)
        goes_on = again > GAP or (scans == 1 and self._is_whole(waiting.index(closing) + 1))
        if scans > _TRUSTED or not (jump < 0 or (uncounted > GAP and goes_on)):
            return None
        return self._now + scans * self._tick_s - (closing.stamp - waiting[0].stamp)

    def _is_whole(self, after: int) -> bool:
        """Whether the frames since the last scan and so many after the jump make up one scan like the one before."""
        return abs(self.since + after - self._frames) <= max(1.0, _UNEVEN * self._frames)
