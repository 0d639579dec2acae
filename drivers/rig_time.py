"""The rig's time of frames as they come off a bus."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection

from drivers.received import Received

OVERDUE_S = 0.5  # wall time without a closing message, after which frames are placed without one
TICKS_LATE = 2.5
MOST_TICKS = 60  # between two scans; more than that is another rig, or the same one started again


class RigTime:
    """A bus at the rig's own pace: frames keep their stamps."""

    speed_up = 1.0

    def __init__(self) -> None:
        self._latest: float | None = None  # by the steady clock

    def place(self, frame: Received) -> list[Received]:
        """Take a frame; returns those whose rig time is known now, in order."""
        self._latest = time.monotonic()
        return [frame]

    def flush(self) -> list[Received]:
        """No more frames come: those that still wait."""
        return []

    def silence(self) -> float:
        """How long the latest frame is ago, s on the rig's clock; 0 before the first."""
        return self.speed_up * (time.monotonic() - self._latest) if self._latest is not None else 0.0


class FastTime(RigTime):
    """A bus that runs `speed_up` times faster than the rig, whose stamps are therefore of no use within a tick.

    A delay of 50 ms on the way is 3 s of a rig sixty times as fast. The number of the scan counts the rig's ticks
    instead: the frames of a scan are spread evenly over its ticks, in whole microseconds, as a recording keeps them.

    closing  says of a frame which scan it closes: None, if none; -1, if the scan has no number
    own      id and kind of messages that are not the rig's: they tell nothing of its time
    """

    def __init__(
        self, speed_up: float, tick_s: float, closing: Callable[[Received], int | None],
        own: Collection[tuple[int, bool]] = (),
    ) -> None:  # fmt: skip
        super().__init__()
        self.speed_up, self._tick_s, self._closing, self._own = speed_up, tick_s, closing, own
        self._patience_s = max(OVERDUE_S, TICKS_LATE * tick_s / speed_up)
        self._waiting: list[Received] = []
        self._placed: tuple[float, float] | None = None  # stamp and rig time of the last frame placed
        self._scan: tuple[int, float] | None = None  # number and rig time of the last scan

    def place(self, frame: Received) -> list[Received]:
        """Frames wait for the end of their scan, or until that is overdue."""
        if self._placed is None:
            self._placed = (frame.time_s, frame.time_s)
        if (frame.id, frame.extended) in self._own:
            return [frame._replace(time_s=round(self._placed[1], 6))]
        self._waiting.append(frame)
        number = self._closing(frame)
        if number is not None:
            return self._release(self._end(number), number)
        if frame.time_s - self._placed[0] > self._patience_s:
            return self.flush()
        return []

    def flush(self) -> list[Received]:
        """Place what waits by its stamps."""
        if not self._waiting or self._placed is None:
            return []
        passed = max(self._waiting[-1].time_s - self._placed[0], 0.0)
        return self._release(self._placed[1] + self.speed_up * passed)

    def _end(self, number: int) -> float:
        """Rig time at the end of a scan."""
        assert self._placed is not None
        next_tick = self._placed[1] + self._tick_s
        if self._scan is None or number < 0:
            return next_tick
        ticks = (number - self._scan[0]) % 65536
        return max(self._scan[1] + ticks * self._tick_s, self._placed[1]) if 0 < ticks <= MOST_TICKS else next_tick

    def _release(self, end_s: float, number: int | None = None) -> list[Received]:
        assert self._placed is not None
        frames, self._waiting = self._waiting, []
        begin_s, count = self._placed[1], len(frames)
        self._placed = (frames[-1].time_s, end_s)
        if number is not None:
            self._scan = (number, end_s)
        self._latest = time.monotonic()
        step = (end_s - begin_s) / count
        return [frame._replace(time_s=round(begin_s + (i + 1) * step, 6)) for i, frame in enumerate(frames)]
