"""The open-loop run: the model from the start on, driven by its inputs alone, with the lags of its thermometers."""

import numpy as np

from estimator.network.assemble import Readings
from estimator.network.discretise import Transition
from estimator.record import Array


class OpenLoop:
    """Carries the states z and the lagged readings s without ever looking at a measurement.

    z <- F z + J w;   tau ds/dt = H z - s, exact for z linear within a tick.
    """

    def __init__(self, z: Array, readings: Readings, tick_s: float) -> None:
        self.z = z.copy()
        self._rows = readings.rows
        self._tick = tick_s
        self._spot = self._rows @ self.z
        self._lagged = self._spot.copy()
        self._keep, self._ramp = lag_filter(readings.tau, tick_s)
        self._change = np.zeros_like(self._spot)

    def step(self, transition: Transition, heat: Array) -> None:
        """Advance by one tick under heat (n,) W."""
        self.z = transition.F @ self.z + transition.J @ heat
        spot = self._rows @ self.z
        self._change = spot - self._spot
        self._lagged = self._keep * self._lagged + (1.0 - self._keep) * self._spot + self._ramp * self._change
        self._spot = spot

    @property
    def now(self) -> tuple[Array, Array, Array]:
        """States z (n,), spots (m,) and lagged readings (m,)."""
        return self.z, self._spot, self._lagged

    @property
    def lag(self) -> Array:
        """Reading minus spot of each channel, (m,): what a lagging thermometer still lacks."""
        return self._lagged - self._spot

    def late(self, ages_s: Array) -> Array:
        """What channels read `ages_s` (m,) before the tick's close had not yet seen, (m,), at most a tick back."""
        return -self._change * np.clip(ages_s / self._tick, 0.0, 1.0)

    @property
    def reading(self) -> Array:
        """What the channels would read, without offsets, (m,)."""
        return self._lagged


def lag_filter(tau: Array, tick_s: float) -> tuple[Array, Array]:
    """How much of a lagged reading is kept over a tick, and how much it follows a ramp of its spot: each (m,).

    keep = e^(-dt / tau);   ramp = 1 - (1 - keep) tau / dt
    """
    tau = tau + np.maximum(1e-9 - np.real(tau), 0.0)  # and moves with tau from none on, where an effect is looked for
    keep = np.exp(-tick_s / tau)
    return keep, 1.0 - (1.0 - keep) * tau / tick_s
