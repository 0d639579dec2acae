"""What thermometers' own errors make of their readings: each has a gain and a lag that are not quite its kind's.

    dy = rise                                       by its share of the gain
    dy <- k dy + dk (s - T) + dr (T' - T)           by its share of the lag; k, r of lag_filter, their slopes by ln tau

They are considered as parameters are (doubt.py), but move nothing besides their own readings.
"""

import numpy as np

from estimator.network.assemble import Readings
from estimator.record import Array
from estimator.state.moves import Course
from estimator.state.open_loop import lag_filter
from estimator.state.tangent import STEP, slope


class OwnErrors:
    """The gains and then the lags of those thermometers that may be off, r of them; of one run, in order of time.

    sd  (r,) as shares: of the rise since the start, and of the lag
    """

    def __init__(self, readings: Readings, start: Array, tick_s: float) -> None:
        """start (m,): what the channels showed of the temperatures at the first sample."""
        self._start, self._late = start, np.zeros_like(start)
        lag_sd = np.where(readings.tau > 0.0, readings.lag_sd, 0.0)
        self._gains, self._lags = np.flatnonzero(readings.gain_sd), np.flatnonzero(lag_sd)
        self.sd = np.append(readings.gain_sd[self._gains], lag_sd[self._lags])
        keep, ramp = lag_filter(readings.tau * (1.0 + 1j * STEP), tick_s)
        self._keep, self._slopes = np.real(keep), (slope(keep), slope(ramp))

    def moved(self, course: Course) -> Array:
        """How the readings of the next K ticks move with each share, (K, m, r); call in order of time."""
        rise = course.lagged[1:] - self._start
        pushed = (course.lagged - course.spot)[:-1] * self._slopes[0] + np.diff(course.spot, axis=0) * self._slopes[1]
        late = np.empty_like(pushed)
        for k, push in enumerate(pushed):
            late[k] = self._late = self._keep * self._late + push
        moved = np.zeros((*rise.shape, len(self.sd)))
        moved[:, self._gains, np.arange(len(self._gains))] = rise[:, self._gains]
        moved[:, self._lags, len(self._gains) + np.arange(len(self._lags))] = late[:, self._lags]
        return moved
