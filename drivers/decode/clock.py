"""The rig's clock from the log's time stamps, by the same rules live and in review.

Time stamps of a bus are wall clock: they jump, stand still and are sometimes rubbish. The rig's clock never runs back.
  - A stamp up to half a tick early counts as simultaneous with the frame before it.
  - A stamp that only one frame has is stray: that frame is dropped.
  - A jump back, or a jump ahead in which the scan number did not move as far, is a jump of the clock: the rig's clock
    goes on as if it had not been. A number may have started again meanwhile, as often as the jump has room for: then
    it is a jump only if the frames on both sides make up one whole scan.
  - Any other jump ahead is silence and takes its time; one of over an hour ends the recording, one of over a year is
    a clock that was set.
  - Where the stamps stand still over whole scans, each scan counts as one tick.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from drivers.budget import Budget
from drivers.decode.scans import GAP, Item, Scans
from drivers.frames import Array, Index, Mask, Tally, Whole

_MOST_WAITING = 100_000  # frames whose stamps stand still after a jump
_YEAR_S = 3.15e7
_UNCONFIRMED = 60.0  # ticks of silence that are believed of the last frames of a log
A_DATE = 1e8  # s: a log's clock that is so far on counts from 1970, and not from the start of the logger


def date_of(time: Array, now: Array) -> float | None:
    """When the rig's clock `now` (n,) began by stamps (n,), s since 1970; None where they tell no date.

    By most of them: a clock may have been set meanwhile, or have lost its date.
    """
    middle = len(time) // 2
    began_s = float(np.partition(time - now, middle)[middle]) if len(time) else 0.0
    return began_s if began_s > A_DATE else None


class RigClock:
    """Turns stamps into the rig's clock: s since the first frame, never running back.

    modulus  after how many scans their number starts again
    where    says of a frame where it stands in the log
    step_s   that is between frames where a jump of their stamps hides it
    """

    def __init__(
        self,
        tick_s: float,
        modulus: int,
        tally: Tally,
        where: Callable[[Any], str],
        budget: Budget,
        step_s: float = 0.0,
    ) -> None:
        self.tick_s = tick_s
        self.tally = tally
        self.where = where
        self.budget = budget
        self.step_s = step_s
        self.ended = False
        self.now = 0.0
        self._stamp = np.nan  # latest stamp of this stretch
        self._offset = 0.0
        self._still = 0  # scans since the stamps stand still
        self._scans = Scans(tick_s, modulus)
        self._waiting: list[Item] = []

    def step(self, frame: Any, stamp: float, closes: bool, scan: int) -> list[tuple[Any, float]]:
        """Take one frame, as an `Item`; returns those now placed as (frame, rig clock in s), in order."""
        if self.ended:
            self.tally.skip("after the end of the recording")
            return []
        item = Item(frame, stamp, closes, scan)
        if self._waiting:
            return self._follow(item)
        if np.isnan(self._stamp):
            self._offset = self._stamp = stamp
        if -self.tick_s / 2 <= stamp - self._stamp <= GAP * self.tick_s:
            return [self._place(item)]
        self._waiting = [item]
        return []

    @property
    def waiting(self) -> bool:
        """Whether frames after a jump wait for the decision about it."""
        return bool(self._waiting)

    def flush(self) -> list[tuple[Any, float]]:
        """Decide on what still waits: no more frames come, and a stamp far ahead is never confirmed."""
        if self._waiting and self._waiting[0].stamp - self._stamp > _UNCONFIRMED * self.tick_s:
            self._drop()
        return self._decide() if self._waiting else []

    @property
    def stamp(self) -> float:
        """The latest stamp that counts: those in doubt are still waiting."""
        return self._stamp

    def advance(self, stamp: float) -> None:
        """No frame came until `stamp`: the rig's clock goes on, and stamps in doubt will never be explained."""
        self._waiting = []
        if stamp > self._stamp:
            self._stamp = stamp
            self.now = max(self.now, stamp - self._offset)

    def run(self, stamps: Array, closes: Mask, scan: Whole) -> Array:
        """The same for a whole log, (n,): NaN for a dropped frame. Regular stretches are taken at once."""
        clock = np.full(len(stamps), np.nan)
        closing = np.flatnonzero(closes)
        odd = _irregular(stamps, closing, self.tick_s)
        at = 0
        while at < len(stamps):
            if self._regular(stamps[at - 1] if at else np.nan):
                upto = int(np.append(odd, len(stamps))[np.searchsorted(odd, at)])
                self._stretch(clock, stamps, closing, scan, at, upto)
                at = upto
            if at < len(stamps):
                for frame, now in self.step(at, float(stamps[at]), bool(closes[at]), int(scan[at])):
                    clock[frame] = now
                at += 1
        for frame, now in self.flush():
            clock[frame] = now
        return clock

    def _regular(self, before: float) -> bool:
        return not (self._waiting or self._still or self.ended) and self._stamp == before

    def _stretch(self, clock: Array, stamps: Array, closing: Index, scan: Whole, start: int, stop: int) -> None:
        """Place frames start ... stop, between which nothing is irregular."""
        if stop == start:
            return
        clock[start:stop] = stamps[start:stop] - self._offset
        self._stamp, self.now = float(stamps[stop - 1]), float(clock[stop - 1])
        self._scans.stretch(stamps, clock, closing, scan, start, stop)

    def _place(self, item: Item) -> tuple[Any, float]:
        frame, stamp = item.frame, item.stamp
        if item.closes and self._scans.stands_still(stamp):
            self._stand_still(frame)
        elif self._still and stamp != self._stamp:
            self._offset, self._still = stamp - self.now, 0
        if stamp < self._stamp:
            self.tally.skip("time stamp before the last one (used)")
        self._stamp = max(self._stamp, stamp)
        self.now = max(self.now, stamp - self._offset)
        self._scans.count(item, self.now)
        return frame, self.now

    def _stand_still(self, frame: Any) -> None:
        if not self._still:
            self.tally.note(
                f"time stands still at {self.now:.3f} s ({self.where(frame)}): each scan counts as one tick"
            )
        self._still += 1
        self._offset -= self.tick_s

    def _follow(self, item: Item) -> list[tuple[Any, float]]:
        """A frame after a jump: it shows whether the one before was stray, or the clock jumped, or it was silent."""
        stamp, first = item.stamp, self._waiting[0]
        from_old, from_new = stamp - self._stamp, stamp - self._waiting[-1].stamp
        near_new = -self.tick_s / 2 <= from_new <= GAP * self.tick_s
        if len(self._waiting) == 1 and -self.tick_s / 2 <= from_old <= GAP * self.tick_s and not near_new:
            self._drop()
            return self.step(*item)
        if not near_new:
            return [*self._decide(), *self.step(*item)]
        self._waiting.append(item)
        known = item.closes or not self._scans.numbered or stamp - first.stamp > GAP * self.tick_s
        return self._decide() if known or len(self._waiting) > _MOST_WAITING else []

    def _drop(self) -> None:
        where = self.where(self._waiting[0].frame)
        self.tally.skip("stray time stamp", len(self._waiting))
        self.tally.note(f"stray time stamp at {self.now:.3f} s ({where}): left out")
        self._waiting = []

    def _decide(self) -> list[tuple[Any, float]]:
        frame, stamp = self._waiting[0][:2]
        waiting, self._waiting = self._waiting, []
        jump = stamp - self._stamp
        at = f"at {self.now:.3f} s ({self.where(frame)})"
        to = self._rig_time(waiting, jump)
        if self._still:
            self._offset, self._still = stamp - self.now, 0
        elif to is not None:
            self.tally.note(f"clock jumps {'ahead' if jump > 0 else 'back'} {abs(jump):.3f} s {at}: ticks go on")
            self._offset = stamp - to
        elif jump > self.budget.gap_s:
            self.tally.doubt(f"silent for {jump / 3600:.1f} h {at}: the recording ends there")
            self.tally.skip("after the end of the recording", len(waiting))
            self.ended = True
            return []
        else:
            self.tally.note(f"silent for {jump:.1f} s {at}")
        self._stamp = stamp
        return [self._place(item) for item in waiting]

    def _rig_time(self, waiting: list[Item], jump: float) -> float | None:
        """Where the rig's clock goes on after a jump of the stamps; None: the time really passed."""
        expected = self._scans.after_jump(waiting, jump)
        if expected is not None:
            return max(self.now, expected)
        # A first frame that is hours off, or any that is years off, is a stamp that was not set.
        started = self.now > 2 * self.tick_s
        set_now = jump > self.budget.gap_s and (jump > _YEAR_S or not started)
        return self.now + self.step_s if jump < 0 or set_now else None


def _irregular(stamps: Array, closing: Index, tick_s: float) -> Index:
    """Frames that a stretch may not contain: the first, one out of order, one after a silence, one at a standstill."""
    if not len(stamps):
        return np.empty(0, np.intp)
    step = np.diff(stamps)
    odd = np.flatnonzero((step < 0) | (step > GAP * tick_s)) + 1
    still = closing[closing > 0]
    still = still[stamps[still] == stamps[still - 1]]
    return np.unique(np.concatenate(([0], odd, still)))
