"""The open-loop run over a whole recording, and what the filter takes from it: lags, late readings and growth.

    z[t] = F z[t-1] + b[t]                          spot = H z
    s[t] = keep s[t-1] + (1 - keep) spot[t-1] + ramp (spot[t] - spot[t-1])          the lagged reading
    lag = s - spot        late = -(spot[t] - spot[t-1]) age        grown = c (z[t] - z[start])

As `OpenLoop` does it a tick at a time; here with the derivative by the start backwards: what is known of the start
depends on noise levels.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from estimator.batch.kernels import coast, remember
from estimator.network.assemble import Readings
from estimator.network.forcing import Drive, Forcing
from estimator.record import Array
from estimator.state.open_loop import lag_filter


@dataclass(frozen=True)
class Nominal:
    """What the open-loop run of T ticks gives: each (T, m), but for states z (T + 1, n) from the start on, grown (T,).

    The readings themselves, without offsets, are `lagged`.
    """

    z: Array
    spot: Array
    lagged: Array
    late_share: Array
    readings: Readings
    growth: Array
    tick_s: float

    @property
    def lag(self) -> Array:
        """Reading minus spot of each channel."""
        return self.lagged - self.spot[1:]

    @property
    def late(self) -> Array:
        """What a reading taken before the tick's close had not yet seen."""
        return -np.diff(self.spot, axis=0) * self.late_share

    @cached_property
    def grown(self) -> Array:
        """Growth of the measured span since the start, um."""
        return (self.z[1:] - self.z[0]) @ self.growth


def nominal(
    start: Array, F: Array, regime: Array, b: Array, readings: Readings, growth: Array, ages_s: Array, tick_s: float
) -> Nominal:
    """Run T ticks from the states `start` (n,), under F (R, n, n)[regime] and the heat's response b (T, n)."""
    z = np.vstack([start, coast(F, regime, b, start)])
    spot = z @ readings.rows.T
    keep, ramp = lag_filter(readings.tau, tick_s)
    lagged = lagging(keep, ramp, spot, np.zeros_like(spot[1:]))
    return Nominal(z, spot, lagged, np.clip(ages_s / tick_s, 0.0, 1.0), readings, growth, tick_s)


def open_loop(forcing: Forcing, drive: Drive, start: Array, ages_s: Array) -> Array:
    """What the channels read by the model alone from states `start` (n,) on, (K, m)."""
    ticks = forcing.ticks(drive)
    F, b = forcing.response(ticks)
    readings, tick_s = forcing.readings, forcing.rig.tick_s
    run = nominal(start, F, ticks.regime, b, readings, readings.growth, ages_s, tick_s)
    return run.lagged + run.late + ticks.offset


def lagging(keep: Array, ramp: Array, spot: Array, pushed: Array) -> Array:
    """Lagged readings (..., T, m) of spots (..., T + 1, m), at first in equilibrium, pushed (..., T, m) further."""
    after, before = spot[..., 1:, :], spot[..., :-1, :]
    return remember(keep, ramp * after + (1 - keep - ramp) * before + pushed, spot[..., 0, :])


def start_slope(run: Nominal, F: Array, regime: Array, to_reading: Array, to_grown: Array) -> Array:
    """Derivatives by the states at the start, (n,), of those by lag and late alike, (T, m), and by grown, (T,)."""
    keep, ramp = lag_filter(run.readings.tau, run.tick_s)
    to_lagged = remember(keep, to_reading[::-1], np.zeros_like(keep))[::-1]
    moved = to_reading * run.late_share
    to_spot = np.zeros_like(run.spot)
    to_spot[1:] += ramp * to_lagged - to_reading - moved
    to_spot[:-1] += (1 - keep - ramp) * to_lagged + moved
    to_spot[0] += keep * to_lagged[0]
    given = to_spot @ run.readings.rows
    given[1:] += to_grown[:, None] * run.growth
    given[0] -= to_grown.sum() * run.growth
    return coast(F.transpose(0, 2, 1), regime[::-1], given[-2::-1], given[-1])[-1]
