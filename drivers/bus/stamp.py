"""Time stamps for frames that no adaptor stamps."""

from __future__ import annotations

import time


class Stamp:
    """Wall time in whole microseconds that never goes back: when the clock is set back, it goes on steadily."""

    def __init__(self) -> None:
        self._ahead_ns = 0  # of the wall clock, against the steady one
        self._last_us = 0

    def next(self) -> bytes:
        """Later than every stamp before, s since 1970: "1699999999.123456"."""
        wall_ns = time.time_ns()
        steady_ns = time.monotonic_ns()
        self._ahead_ns = max(self._ahead_ns, wall_ns - steady_ns)
        self._last_us = max((steady_ns + self._ahead_ns) // 1000, self._last_us + 1)
        return b"%d.%06d" % divmod(self._last_us, 1_000_000)
