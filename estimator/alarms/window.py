"""Tests of the innovations over one window after the other.

    bias      |mean of innovation / sd|     > allowance + w normal quantile / sqrt(n)
    nis       sum of NIS                    > allowance * w^2 * chi2 quantile for so many channels
    scatter   the same without w^2, which is what makes it so
    rejected  more than a twentieth of a channel's readings, and not just one or two, jumped away and back

w is how many times as much as the model says thermometers scatter by themselves (beside/scatter.py), at most 3.

No model is perfect: bias and NIS may be off by an allowance before they count, larger than what a fitted model leaves.
The quantiles are such that on a rig that is off by the whole allowance all of them together fail once in FALSE_S
without cause; on one that is right, hardly ever.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from estimator.faults.beside.scatter import Scatter
from estimator.faults.fault import Fault
from estimator.faults.sentences import place_of
from estimator.record import Array
from estimator.rig import Rig
from estimator.step import Step

FALSE_S = 30 * 86400.0
NIS_ALLOWED = 1.5
NOISIER = 3.0  # times as much scatter: with so much the estimate is as good as its sd says, with five times it is not
REJECTED = 0.05
SOME = 3


@dataclass(frozen=True)
class Window:
    """So many ticks, over which the mean of scaled innovations may be off by `bias` sd."""

    ticks: int
    bias: float


WINDOWS = (Window(60, 1.0), Window(600, 0.6))


class WindowTest:
    """The sums over a window of one rig. `first_s` is when it began."""

    def __init__(self, rig: Rig, window: Window, false_s: float = FALSE_S) -> None:
        self.rig, self.window = rig, window
        self.over_s = window.ticks * rig.tick_s
        self.share = self.over_s / false_s / len(WINDOWS) / (len(rig.names) + 1)
        self._begin(np.nan)

    def _begin(self, time_s: float) -> None:
        m = len(self.rig.names)
        self.first_s, self._ticks, self._nis, self._channels = time_s, 0, 0.0, 0
        self._sum, self._count, self._wild = np.zeros(m), np.zeros(m), np.zeros(m)
        self._broken = np.zeros(m, dtype=bool)
        self._scatter = Scatter(self.rig.is_thermometer)

    def add(self, step: Step) -> bool:
        """Take one tick; whether the window is full."""
        if self._ticks in (0, self.window.ticks):
            self._begin(step.time_s)
        self._ticks += 1
        if np.isfinite(step.nis):
            self._nis, self._channels = self._nis + step.nis, self._channels + step.nis_channels
        fused = np.flatnonzero(step.fused)
        scaled = np.where(step.fused, step.innovation / step.innovation_sd, np.nan)
        self._scatter.hear(scaled[None])
        self._sum[fused] += scaled[fused]
        self._count[fused] += 1
        self._wild += step.fault == Fault.JUDGED
        self._broken = step.fault > Fault.JUDGED  # which has an alarm of its own
        return self._ticks == self.window.ticks

    def failed(self) -> Iterator[tuple[str, str, str]]:
        """Of a full window: kind, channel and sentence of each test that failed."""
        most = NIS_ALLOWED * scipy.special.chdtri(self._channels, self.share) if self._channels else np.inf
        if self._nis > most * self._noisier**2:
            ratio = np.sqrt(self._nis / self._channels)
            yield "nis", "", f"the innovations are {ratio:.1f} times as large as they should be"
        elif self._nis > most:
            text = f"the thermometers scatter {self._noisier:.1f} times as much as the model says: ballscrew tune"
            yield "scatter", "", text
        for i in np.flatnonzero(self._biased()):
            mean = self._sum[i] / self._count[i]
            side = "above" if mean > 0 else "below"
            text = f"{place_of(self.rig, i)} reads {abs(mean):.1f} sd {side} what was predicted"
            yield "bias", self.rig.names[i], text
        read = self._count + self._wild
        for i in np.flatnonzero((self._wild >= SOME) & (self._wild > REJECTED * read) & ~self._broken):
            text = f"{place_of(self.rig, i)}: {self._wild[i]:.0f} of {read[i]:.0f} readings rejected"
            yield "rejected", self.rig.names[i], text

    @property
    def _noisier(self) -> float:
        return min(self._scatter.times() ** 0.5, NOISIER)

    def _biased(self) -> Array:
        """Channels that are off by more than the allowance, (m,) bool."""
        count = np.maximum(self._count, 1.0)
        limit = self.window.bias - scipy.special.ndtri(self.share / 2) * self._noisier / np.sqrt(count)
        return np.asarray(np.abs(self._sum) / count > limit)
