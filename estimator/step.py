"""What the filter says: a Step for each tick, one ChannelStep for each channel, whatever the sensor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from estimator.record import Array


class Mode(IntEnum):
    """What the estimate rests on; values as sent on the bus."""

    INIT = 0
    PREDICT = 1
    UPDATE = 2
    COASTING = 3
    INVALID = 14


@dataclass(frozen=True, slots=True)
class ChannelStep:
    """One channel at one tick: degC and K, or um for the displacement. `why` says why it was not fused."""

    channel: str
    measured: float
    predicted: float
    innovation: float
    innovation_sd: float
    fused: bool
    why: str


@dataclass(frozen=True, slots=True)
class Step:
    """The estimate after one tick.

    time_s            s since the first frame
    elongation_um     growth of the measured span since the start; sigma_um its standard deviation
    open_loop_um      the same by the model alone
    profile_C         (x,) temperatures at the estimator's display places; profile_sd_K likewise
    bodies_C          (bodies,) temperatures of nut and housings
    error_at_table_um growth between the anchor bearing and the nut's centre; NaN where the position is not known
    measured, predicted, innovation, innovation_sd, fused, why   (m,) for each channel
    open_loop         (m,) what the channels would read by the model alone
    nis, nis_channels e' S^-1 e over the fused channels, and how many they are
    """

    time_s: float
    mode: Mode
    elongation_um: float
    sigma_um: float
    open_loop_um: float
    profile_C: Array
    profile_sd_K: Array
    bodies_C: Array
    error_at_table_um: float
    error_at_table_sd_um: float
    names: tuple[str, ...]
    measured: Array
    predicted: Array
    innovation: Array
    innovation_sd: Array
    fused: Array
    why: tuple[str, ...]
    open_loop: Array
    nis: float
    nis_channels: int

    def channel(self, name: str) -> ChannelStep:
        """One channel of this step."""
        i = self.names.index(name)
        return ChannelStep(
            name,
            float(self.measured[i]),
            float(self.predicted[i]),
            float(self.innovation[i]),
            float(self.innovation_sd[i]),
            bool(self.fused[i]),
            self.why[i],
        )


class Track:
    """The steps of a whole recording: each field of Step as an array with a leading axis K.

    x_mm     (x,) places of the profile
    bodies   names of the bodies
    names    channel names (m,)
    """

    def __init__(self, x_mm: Array, bodies: tuple[str, ...], steps: Sequence[Step]) -> None:
        self.x_mm, self.bodies, self.names = x_mm, bodies, steps[0].names
        self.time_s = np.array([step.time_s for step in steps])
        self.mode = np.array([step.mode for step in steps])
        self.elongation_um = np.array([step.elongation_um for step in steps])
        self.sigma_um = np.array([step.sigma_um for step in steps])
        self.open_loop_um = np.array([step.open_loop_um for step in steps])
        self.profile_C = _stack([step.profile_C for step in steps])
        self.profile_sd_K = _stack([step.profile_sd_K for step in steps])
        self.bodies_C = _stack([step.bodies_C for step in steps])
        self.error_at_table_um = np.array([step.error_at_table_um for step in steps])
        self.measured = np.array([step.measured for step in steps])
        self.predicted = np.array([step.predicted for step in steps])
        self.innovation = np.array([step.innovation for step in steps])
        self.innovation_sd = np.array([step.innovation_sd for step in steps])
        self.fused = np.array([step.fused for step in steps])
        self.open_loop = np.array([step.open_loop for step in steps])
        self.nis = np.array([step.nis for step in steps])
        self.nis_channels = np.array([step.nis_channels for step in steps])

    def __len__(self) -> int:
        return len(self.time_s)


def _stack(rows: list[Array]) -> Array:
    """Rows into a matrix; the empty ones of ticks before the start become NaN."""
    width = max(len(row) for row in rows)
    return np.array([row if len(row) else np.full(width, np.nan) for row in rows])
