"""Spans of a recording: minutes in a row in which the screw only drives or only stands."""

from dataclasses import dataclass

import numpy as np

from estimator.inputs.phase import phase_of
from estimator.record import Array, Recording

SPAN_S = 300.0  # heat is slower than that to show, and an event has to be told within ten minutes
FEWEST, MOST = 24, 80  # spans that a short and a long recording are cut into


@dataclass(frozen=True)
class Spans:
    """B spans of T ticks: of_tick (T,), the span of each; from_s, at_s (B,) beginning and middle; drive (B,) bool."""

    of_tick: Array
    from_s: Array
    at_s: Array
    drive: Array

    def __len__(self) -> int:
        return len(self.from_s)

    def phase(self, at_s: float) -> tuple[bool, float]:
        """Whether the screw turns at a time, and for how long it has, or has stood, s."""
        span = max(int(np.searchsorted(self.from_s, at_s, "right")) - 1, 0)
        others = np.flatnonzero(self.drive[:span] != self.drive[span])
        return bool(self.drive[span]), at_s - float(self.from_s[others[-1] + 1 if len(others) else 0])


def spans(recording: Recording, most_s: float | None = None) -> Spans:
    """Cut a recording at every start and stop, and at least every so often, as a rule every five minutes; in more or
    fewer if it is no day's."""
    time_s, drive = recording.time_s, phase_of(recording) == "drive"
    lasts = float(time_s[-1] - time_s[0])
    most_s = most_s or max(min(SPAN_S, lasts / FEWEST), lasts / MOST)
    turned = np.flatnonzero(np.diff(drive, prepend=not drive[0]))
    stretch = np.searchsorted(turned, np.arange(len(time_s)), "right") - 1
    part = np.floor((time_s - time_s[turned[stretch]]) / most_s + 1e-9).astype(int)
    firsts = np.flatnonzero(np.diff(stretch, prepend=-1) | np.diff(part, prepend=-1))
    of_tick = np.searchsorted(firsts, np.arange(len(time_s)), "right") - 1
    at_s = np.bincount(of_tick, time_s) / np.bincount(of_tick)
    return Spans(of_tick, time_s[firsts], at_s, drive[firsts])
