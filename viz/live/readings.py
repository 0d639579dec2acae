"""Readings of the displacement beside the elongation: those that the filter used, those that it did not, and the dial
at rest as a band, joined to the drive before it.

What a filter says of a reading comes with its tick: a reading is drawn at the elongation that it speaks for, which is
the filter's last estimate, grown by what the model grows in the tick, and the innovation.

The dial stands on another zero at each rest. What joins it is what the model alone leaves of a reading, which is nearly
the same just before and after a stop; a line through half a minute of it, at the stop and now, has no scatter.

    left = reading - the model alone;   dial = growth by the model alone + left + shift
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from estimator.inputs.phase import turns
from estimator.record import Array, Sample
from estimator.rig import Rig
from estimator.step import Track
from viz.drawing import paths, series
from viz.drawing.entity import Entity
from viz.drawing.scale import Range

READING, DIAL = "displacement", "displacement_direct"  # the channel that is drawn, and the input that reads at rest
EDGE_S = 30.0
FEW = 10  # readings, through less there goes no line


class Level(NamedTuple):
    """What is left at a time, um, and its variance, um2."""

    um: float
    variance: float


class Dial:
    """The elongation by readings alone, a tick at a time; told at rest, from half a minute after the stop on."""

    def __init__(self) -> None:
        self._end = self._zero = self._shift = None  # type: Level | None
        self._driving, self._begin_s, self._left = False, np.nan, np.empty((0, 2))
        self._last: Level | None = None

    def tick(self, time_s: float, driving: bool, left_um: float, joined_um: float) -> Level | None:
        """Take what is left of the reading of a tick, NaN for none; `joined_um` where nothing was ever joined."""
        if driving != self._driving or np.isnan(self._begin_s):
            self._stretch(time_s, driving, joined_um)
        if np.isfinite(left_um):
            self._left = np.vstack([self._left, (time_s, left_um)])[-int(4 * EDGE_S) :]
            self._left = self._left[self._left[:, 0] >= time_s - EDGE_S]
        if len(self._left) < FEW or time_s - self._begin_s < EDGE_S:
            return None
        if self._shift is None:
            self._shift = self._joint(_line(self._left, self._begin_s))
        now = _line(self._left, time_s)
        self._last = Level(now.um + self._shift.um, now.variance + self._shift.variance)
        return None if driving else self._last

    def _stretch(self, time_s: float, driving: bool, joined_um: float) -> None:
        """A drive or a rest begins where the one before has ended."""
        self._end = self._last or self._end or Level(joined_um, 0.0)
        self._driving, self._begin_s, self._left = driving, time_s, np.empty((0, 2))
        self._last = self._shift = None

    def _joint(self, first: Level) -> Level:
        """What is added to this stretch; all drives have one zero."""
        assert self._end is not None
        joint = Level(self._end.um - first.um, self._end.variance + first.variance)
        if self._driving:
            self._zero = joint = self._zero or joint
        return joint


def _line(left: Array, at_s: float) -> Level:
    """A line through what is left at some times (n, 2), at one of them."""
    apart = left[:, 0] - at_s
    (slope, um), n = np.polyfit(apart, left[:, 1], 1), len(left)
    scatter = ((left[:, 1] - um - slope * apart) ** 2).sum() / (n - 2)
    return Level(float(um), float(scatter * (1 / n + apart.mean() ** 2 / (n * apart.var()))))


class Readings:
    """What one stream shows of the readings of one channel.

    extent  of the plot that they stand in
    """

    def __init__(self, at: Entity, rig: Rig, window_s: float) -> None:
        self._at, self._rig, self._window_s = at, rig, window_s
        self._column, self._dial = rig.index(READING), Dial()
        self._before_um, self._alone_um = np.full(2, np.nan), np.nan  # by the filter and the model alone, at a tick
        self._dot = np.full((1, 3), np.nan)  # time and value of the reading drawn last, and whether it was used
        if DIAL in rig.inputs:
            (at / paths.ELONGATION / "dial").band(series.DIAL, paths.DIAL, 1.0)

    def values(self, track: Track, innovation: Array) -> Array:
        """The elongation that readings speak for, (n,) um."""
        now = np.stack([track.elongation_um, track.open_loop_um], axis=-1)
        before = np.concatenate([self._before_um[None], now[:-1]])
        self._before_um = now[-1]
        return np.asarray(before[:, 0] + now[:, 1] - before[:, 1] + innovation)

    def send(self, track: Track, um: Array, extent: Range) -> None:
        """Log those far enough apart from the one drawn last."""
        used = track.fused[:, self._column]
        rows = np.concatenate([self._dot, np.stack([track.time_s, um, used], axis=-1)])
        shown = series.spaced(rows[:, 0], rows[:, 1], (0.0, self._window_s), extent)
        if len(shown):
            self._dot = rows[shown[-1:]]
        drawn = rows[shown[shown > 0]]
        series.send_readings(self._at, drawn[:, 0], drawn[:, 1], drawn[:, 2] > 0)

    def send_dial(self, samples: Sequence[Sample], track: Track) -> None:
        """Log the dial at rest."""
        told = np.full((len(samples), 2), np.nan)
        for k, sample in enumerate(samples):
            if found := self._dial.tick(track.time_s[k], *self._left(sample, track, k)):
                told[k] = track.open_loop_um[k] + found.um, np.sqrt(found.variance)
        (self._at / paths.ELONGATION / "dial").spans(track.time_s, told[:, 0], told[:, 1])

    def _left(self, sample: Sample, track: Track, k: int) -> tuple[bool, float, float]:
        """Whether it drives, what is left of what was read then, and of the filter, um."""
        driving, alone = bool(turns(sample.omega)), float(track.open_loop[k, self._column])
        late = (alone - self._alone_um) * np.clip(sample.ages_s[self._column] / self._rig.tick_s, 0.0, 1.0)
        self._alone_um = alone
        reading = track.measured[k, self._column] + late if driving else sample.inputs.get(DIAL, np.nan)
        return driving, float(reading - alone), float(track.elongation_um[k] - track.open_loop_um[k])
