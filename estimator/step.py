"""What the filter says: a Step for each tick, one ChannelStep for each channel, whatever the sensor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
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
    position_mm       of the table, that the error there is for; a tick or two old where the drive was late
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
    position_mm: float = float("nan")

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


@dataclass(frozen=True)
class Track:
    """The steps of a whole recording: the fields of Step with a leading axis K.

    x_mm     (x,) places of the profile
    bodies   names of the bodies
    names    channel names (m,)
    """

    x_mm: Array
    bodies: tuple[str, ...]
    names: tuple[str, ...]
    time_s: Array
    mode: Array
    elongation_um: Array
    sigma_um: Array
    open_loop_um: Array
    profile_C: Array
    profile_sd_K: Array
    bodies_C: Array
    error_at_table_um: Array
    measured: Array
    predicted: Array
    innovation: Array
    innovation_sd: Array
    fused: Array
    open_loop: Array
    nis: Array
    nis_channels: Array
    position_mm: Array

    @classmethod
    def of(cls, steps: Sequence[Step], x_mm: Array, bodies: tuple[str, ...]) -> Track:
        """Steps one after the other."""
        series = {key: _stack([np.asarray(getattr(step, key)) for step in steps]) for key in SERIES}
        return cls(x_mm, bodies, steps[0].names, **series)

    @classmethod
    def joined(cls, parts: Sequence[Track]) -> Track:
        """Parts of one run, one after the other; places and bodies are those of the last."""
        last = parts[-1]
        series = {key: np.concatenate([_widened(getattr(p, key), getattr(last, key)) for p in parts]) for key in SERIES}
        return cls(last.x_mm, last.bodies, last.names, **series)

    def __len__(self) -> int:
        return len(self.time_s)


SERIES = tuple(field.name for field in fields(Track) if field.name not in ("x_mm", "bodies", "names"))


def _widened(rows: Array, like: Array) -> Array:
    """Rows of ticks before the start, as wide as those after it."""
    return rows if rows.shape[1:] == like.shape[1:] else np.full((len(rows), *like.shape[1:]), np.nan)


def _stack(rows: list[Array]) -> Array:
    """Rows into an array; the empty ones of ticks before the start become NaN."""
    width = max(row.size for row in rows)
    return np.array([row if row.size == width else np.full(width, np.nan) for row in rows])
