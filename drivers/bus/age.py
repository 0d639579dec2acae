"""How old a frame is when it is received: it may have lain in the buffers of the kernel, the network or a hub."""

import math

BACK_S = 0.5  # a stamp that runs back by more is a clock that was set
DRIFT = 1e-3  # that the clock of the stamps may run slower than ours


class Age:
    """Now less its stamp, above the least that this was: so the clock of the stamps may be any.

    The least is found anew where a frame was waited for, since the buffers were empty then, and where a clock was set.
    Frames that share a stamp are as old as the first of them: some clocks are coarse, and some stand still.
    """

    def __init__(self) -> None:
        self._stamp, self._now, self._least, self._age = -math.inf, 0.0, math.inf, 0.0

    def of(self, stamp: float, now_s: float, waited_for: bool) -> float:
        """Of a frame stamped so, received at `now_s` on a steady clock, s."""
        if stamp == self._stamp:
            return self._age
        lag = now_s - stamp
        if waited_for or stamp < self._stamp - BACK_S:
            self._least = lag
        self._least = min(self._least + DRIFT * (now_s - self._now), lag)
        self._stamp, self._now = stamp, now_s
        self._age = lag - self._least
        return self._age
