"""The rig's time of frames as they come off a bus."""

import time
from collections.abc import Callable, Collection

from drivers.frames import LATEST_S
from drivers.received import Received

OVERDUE_S = 0.5  # wall time without a closing message, after which frames are placed without one
TICKS_LATE = 2.5
JITTER_S = 0.05  # wall time by which a stamp may be off
MOST_TICKS = 60  # between two scans; more than that is another rig, or the same one started again
SLOW, SLOW_SCANS = 5.0, 20  # times longer than it should, that many scans take in a row

Own = Collection[tuple[int, bool]]


class RigTime:
    """A bus at the rig's own pace: frames keep their stamps.

    own      id and kind of messages that are not the rig's: they tell nothing of its time, nor do error frames and
             frames with an absurd stamp
    trouble  why the time is in doubt, in one sentence
    """

    speed_up, trouble = 1.0, ""

    def __init__(self, own: Own = ()) -> None:
        self._own = own
        self._latest: float | None = None  # when the rig was heard last, by the steady clock

    def place(self, frame: Received) -> list[Received]:
        """Take a frame; returns those whose rig time is known now, in order."""
        if self._is_the_rigs(frame):
            self._latest = time.monotonic()
        return [frame]

    def overdue(self) -> list[Received]:
        """No frame has come for a moment: those that wait no longer."""
        return []

    def flush(self) -> list[Received]:
        """No more frames come: those that still wait."""
        return []

    def silence(self) -> float:
        """How long the rig has not been heard, s on its clock; 0 before its first frame."""
        return self.speed_up * (time.monotonic() - self._latest) if self._latest is not None else 0.0

    def _is_the_rigs(self, frame: Received) -> bool:
        return frame.kind == "data" and (frame.id, frame.extended) not in self._own and not _is_absurd(frame)


class FastTime(RigTime):
    """A bus that runs `speed_up` times faster than the rig, whose stamps are therefore of no use within a tick.

    A delay of 50 ms on the way is 3 s of a rig sixty times as fast. The number of the scan counts the rig's ticks
    instead: the frames of a scan are spread evenly over its ticks, in whole microseconds, as a recording keeps them.

    closing  says of a frame which scan it closes: None, if none; -1, if the scan has no number
    modulus  after how many scans their number starts again
    """

    def __init__(
        self, speed_up: float, tick_s: float, closing: Callable[[Received], int | None], modulus: int, own: Own = ()
    ) -> None:
        super().__init__(own)
        self.speed_up, self._tick_s, self._closing, self._modulus = speed_up, tick_s, closing, modulus
        self._patience_s = max(OVERDUE_S, TICKS_LATE * tick_s / speed_up)
        self._waiting: list[Received] = []
        self._placed: tuple[float, float] | None = None  # stamp and rig time of the last frame placed
        self._scan: tuple[int, float, float] | None = None  # number, rig time and stamp of the last scan
        self._slow = 0
        self._lull_s = 0.0  # before the first of those that wait, by the steady clock

    def place(self, frame: Received) -> list[Received]:
        """Frames wait for the end of their scan, or until that is overdue."""
        if _is_absurd(frame):
            return [frame]  # who decodes it will refuse it
        if self._placed is None:
            self._placed = (frame.time_s, frame.time_s)
        if not self._is_the_rigs(frame):
            return [frame._replace(time_s=round(self._placed[1], 6))]
        # before a gap nothing has waited for long, and how long the gap was the next scan will tell
        before = self.flush() if self._waiting and self._is_far(frame, self._waiting[-1]) else []
        if not self._waiting:
            self._lull_s = self.silence() / self.speed_up
        self._latest = time.monotonic()
        self._waiting.append(frame)
        number = self._closing(frame)
        if number is not None:
            return [*before, *self._release(self._end(number, frame.time_s), number)]
        return [*before, *(self.flush() if self._is_far(frame, self._waiting[0]) else [])]

    def overdue(self) -> list[Received]:
        """Frames whose scan does not end."""
        return self.flush() if self.silence() > self.speed_up * self._patience_s else []

    def flush(self) -> list[Received]:
        """Place what waits by its stamps, which may be years ahead: no further on than it can have taken."""
        if not self._waiting or self._placed is None:
            return []
        first, last = self._waiting[0].time_s, self._waiting[-1].time_s
        lull_s = min(max(first - self._placed[0], 0.0), self._lull_s + JITTER_S)
        return self._release(self._placed[1] + self.speed_up * (lull_s + max(last - first, 0.0)))

    def _is_far(self, frame: Received, other: Received) -> bool:
        return abs(frame.time_s - other.time_s) > self._patience_s

    def _end(self, number: int, stamp: float) -> float:
        """Rig time at the end of a scan."""
        assert self._placed is not None
        next_tick = self._placed[1] + self._tick_s
        if self._scan is None or number < 0:
            return next_tick
        ticks = (number - self._scan[0]) % self._modulus
        if not 0 < ticks <= MOST_TICKS:
            return next_tick
        self._doubt((stamp - self._scan[2]) * self.speed_up / (ticks * self._tick_s))
        return max(self._scan[1] + ticks * self._tick_s, self._placed[1])

    def _doubt(self, longer: float) -> None:
        """Note scans that take `longer` than they should."""
        self._slow = self._slow + 1 if longer > SLOW else 0
        if self._slow == SLOW_SCANS:
            self.trouble = f"scans take {longer:.0f} times as long as --speed-up {self.speed_up:g} says: is it right?"
        elif not self._slow:
            self.trouble = ""

    def _release(self, end_s: float, number: int | None = None) -> list[Received]:
        assert self._placed is not None
        frames, self._waiting = self._waiting, []
        begin_s, count = self._placed[1], len(frames)
        self._placed = (frames[-1].time_s, end_s)
        if number is not None:
            self._scan = (number, end_s, frames[-1].time_s)
        step = (end_s - begin_s) / count
        return [frame._replace(time_s=round(begin_s + (i + 1) * step, 6)) for i, frame in enumerate(frames)]


def _is_absurd(frame: Received) -> bool:
    return not 0 <= frame.time_s < LATEST_S
