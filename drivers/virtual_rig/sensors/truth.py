"""What really happened on the rig, tick by tick, whether a sensor saw it or not."""

from typing import Any, NamedTuple, Self

import numpy as np

from drivers.virtual_rig.sensors.environment import Environment
from drivers.virtual_rig.sensors.probes import Gauge


class Truth(NamedTuple):
    """One row a second (n,); `channels` (n, 15). Temperatures degC, growth um since the start, torques N m.

    `table_um` (n, 9) is the growth between the anchor bearing and the nut's centre, were the table at TABLE_MM.

    `environment` is what the thermometers around the screw stand in.
    """

    time_s: np.ndarray
    channels: np.ndarray
    motor_um: np.ndarray
    free_um: np.ndarray
    table_um: np.ndarray
    environment: Environment
    board: np.ndarray
    seat: np.ndarray
    nut_torque: np.ndarray
    bearing_torque: np.ndarray

    @classmethod
    def of(cls, rows: list[tuple[Any, ...]]) -> Self:
        """Columns from the rows of single ticks."""
        columns = {name: np.array(column) for name, column in zip(cls._fields, zip(*rows, strict=True), strict=True)}
        return cls(environment=Environment(*columns.pop("environment").T), **columns)

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
        rises = (t - t[0] for t in (self.environment.probe, self.environment.bar, self.seat))
        return Gauge(self.motor_um, self.free_um, *rises)
