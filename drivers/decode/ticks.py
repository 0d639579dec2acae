"""Where ticks close on the rig's clock: the same rule live and in review."""

import numpy as np

from drivers.frames import Array, Index, Mask, Tally
from estimator.errors import InputError

TOO_SOON = "closing message too soon (used)"
_FEW, _OTHER_UNIT = 20, 100.0  # closing messages that show nothing; ticks that no rig's clock is off by
_EVEN = 0.1  # how far off a step may be, as a share
_PATIENCE = 1.5  # ticks without a closing message, after which the timer closes one


class Ticks:
    """Where ticks close: with the closing message, or one and a half ticks after the last close with the timer.

    A timer's tick is dated one tick after the last, so that a lost message does not shift the following ticks. A
    closing message less than half a tick after the last close belongs to the next tick: bursts add no rows. Without a
    closing message the timer alone runs, half a tick out of phase with the first frame.
    """

    def __init__(self, tick_s: float, by_message: bool) -> None:
        self.tick_s = tick_s
        self.patience = _PATIENCE if by_message else 1.0
        self.last = 0.0 if by_message else -tick_s / 2
        self.closed = 0

    def due(self, now: float) -> list[tuple[float, float]]:
        """Ticks that the timer closes before a frame at `now`: (last instant inside, date), s."""
        ticks = []
        while now > (until := self.last + self.patience * self.tick_s):
            self.last += self.tick_s
            ticks.append((until, self.last))
        self.closed += len(ticks)
        return ticks

    def close(self, now: float) -> bool:
        """Whether a closing message at `now` closes a tick."""
        if self.closed and now - self.last < self.tick_s / 2:
            return False
        self.last = now
        self.closed += 1
        return True

    def rest(self, now: float) -> list[tuple[float, float]]:
        """At the end of a log: the open tick, if it lasted."""
        if now - self.last < self.tick_s:
            return []
        self.last += self.tick_s
        self.closed += 1
        return [(now, self.last)]


def at_the_pace(name: str, closed: Array, tick_s: float) -> None:
    """Closing messages, (n,) s, that come far faster or slower than ticks have stamps in another unit: InputError.

    On the median and on the mean: a gateway may send each of them twice, a log may have gaps.
    """
    steps = np.diff(closed)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).sum() > _FEW else tick_s
    paces = np.array([usual, steps.mean() if len(steps) > _FEW else tick_s]) / tick_s
    if not ((paces > 1 / _OTHER_UNIT) & (paces < _OTHER_UNIT)).any():
        raise InputError(
            f"{name}: the message that closes a tick comes each {usual:.3g} s, rig.toml's tick_s is {tick_s:g}: "
            "its times count something else than seconds; export them as seconds"
        )


def split(
    name: str, now: Array, closes: Mask, ticks: Ticks, most: int, tally: Tally, too_soon: str = TOO_SOON
) -> tuple[Index, Array]:
    """Cut a whole log into ticks: the tick of each frame inside them, rising, and when each tick closed, (K,) s.

    now     (n,) s on the rig's clock, rising     most  no more ticks than this
    closes  (n,) closing messages                 name  of the log; one without a whole tick is an InputError
    """
    ends: list[int] = []
    dates: list[float] = []

    def timed(due: list[tuple[float, float]]) -> None:
        for until, date in due:
            ends.append(int(np.searchsorted(now, until, side="right")))
            dates.append(date)

    for index in np.flatnonzero(closes).tolist():
        timed(ticks.due(float(now[index])))
        if len(ends) >= most:
            tally.doubt(f"longer than {most} ticks: the recording ends at {dates[most - 1]:.1f} s")
            break
        if ticks.close(float(now[index])):
            ends.append(index + 1)
            dates.append(float(now[index]))
        else:
            tally.skip(too_soon)
    else:
        timed(ticks.due(float(now[-1])))
        timed(ticks.rest(float(now[-1])))
    if not ends:
        raise InputError(f"{name} over {now[-1]:.3g} s, less than one tick of {ticks.tick_s:g} s")
    tally.skip("after the last whole tick", len(now) - ends[:most][-1])
    return np.repeat(np.arange(len(ends[:most])), np.diff(ends[:most], prepend=0)), np.array(dates[:most])


def told_step(date: Array, tick_s: float, tally: Tally) -> None:
    """A note where ticks, dated (n,) s, are not as far apart as the rig says: each is one step of the model."""
    step = float(np.median(np.diff(date))) if len(date) > _FEW else tick_s
    if abs(step / tick_s - 1.0) > _EVEN:
        tally.doubt(
            f"ticks come each {step:.3g} s, and each counts as {tick_s:g} s; in rig.toml say tick_s = {step:.3g}"
        )
