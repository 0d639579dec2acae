"""What really happened on the rig, tick by tick, whether a sensor saw it or not."""

from typing import NamedTuple, Self

import numpy as np

from drivers.virtual_rig.sensors.environment import Environment
from drivers.virtual_rig.sensors.probes import Gauge


class Truth(NamedTuple):
    """One row a second (n,); `channels` (n, 15). Temperatures degC, growth um since the start, torques N m."""

    time_s: np.ndarray
    channels: np.ndarray
    motor_um: np.ndarray
    free_um: np.ndarray
    ambient: np.ndarray
    base: np.ndarray
    bracket_anchor: np.ndarray
    bracket_free: np.ndarray
    nut: np.ndarray
    probe: np.ndarray
    bar: np.ndarray
    board: np.ndarray
    seat: np.ndarray
    nut_torque: np.ndarray
    bearing_torque: np.ndarray

    @classmethod
    def of(cls, rows: list[tuple]) -> Self:
        """Columns from the rows of single ticks."""
        return cls(*(np.array(column) for column in zip(*rows, strict=True)))

    @property
    def elongation_um(self) -> np.ndarray:
        """Growth of the measured span: what lies beyond the anchor and what lies before it, um"""
        return self.motor_um + self.free_um

    @property
    def rises(self) -> np.ndarray:
        """Bore wall at the channels above the start, K: (n, 15)"""
        return self.channels - self.channels[0]

    @property
    def gauge(self) -> Gauge:
        """What the displacement readings follow."""
        return Gauge(
            self.motor_um, self.free_um, self.probe - self.probe[0], self.bar - self.bar[0], self.seat - self.seat[0]
        )

    @property
    def environment(self) -> Environment:
        """What the thermometers around the screw stand in."""
        return Environment(
            self.ambient, self.base, self.bracket_anchor, self.bracket_free, self.nut, self.probe, self.bar
        )


class Profile(NamedTuple):
    """The whole screw's mean temperature rise now and then: time_s (m,), x_mm (436,), rise (m, 436) K"""

    time_s: np.ndarray
    x_mm: np.ndarray
    rise: np.ndarray
