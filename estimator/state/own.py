"""What thermometers' own errors make of their readings: each has a gain and a lag that are not quite its kind's.

    y  <- y + rise d_gain            ds  <- ds + (dk (s - T) + dr (T' - T)) d_lag,   k, r of lag_filter, by ln tau

Of every one by itself, and considered as parameters are (doubt.py).
"""

from __future__ import annotations

import numpy as np

from estimator.network.assemble import Readings
from estimator.record import Array
from estimator.state.moves import Course
from estimator.state.open_loop import lag_filter

STEP = 1e-30


class OwnErrors:
    """The gains and then the lags of those thermometers that may be off, r of them.

    sd  (r,) as shares: of the rise since the start, and of the lag
    """

    def __init__(self, readings: Readings, start: Array, tick_s: float) -> None:
        """start (m,): what the channels showed of the temperatures at the first sample."""
        self._start, self._m = start, len(readings.tau)
        lag_sd = np.where(readings.tau > 0.0, readings.lag_sd, 0.0)
        self._gains, self._lags = np.flatnonzero(readings.gain_sd), np.flatnonzero(lag_sd)
        self.sd = np.append(readings.gain_sd[self._gains], lag_sd[self._lags])
        keep, ramp = lag_filter(readings.tau * (1.0 + 1j * STEP), tick_s)
        self._keep, self._ramp = np.imag(keep) / STEP, np.imag(ramp) / STEP

    def offset(self, course: Course) -> Array:
        """What gains add to the readings of K ticks, (K, m, r) per share."""
        rise, lags = course.lagged[1:] - self._start, np.zeros((len(course.grown_um), self._m, len(self._lags)))
        return np.concatenate([_each(rise, self._gains), lags], axis=2)

    def pushed(self, course: Course) -> Array:
        """What lags add to the lagged readings in each of K ticks, (K, m, r) per share."""
        late = (course.lagged - course.spot)[:-1] * self._keep + np.diff(course.spot, axis=0) * self._ramp
        gains = np.zeros((len(late), self._m, len(self._gains)))
        return np.concatenate([gains, _each(late, self._lags)], axis=2)


def _each(values: Array, channels: Array) -> Array:
    """Of values (K, m) those of some channels, each in a column of its own, (K, m, r)."""
    alone = np.zeros((*values.shape, len(channels)))
    alone[:, channels, np.arange(len(channels))] = values[:, channels]
    return alone
