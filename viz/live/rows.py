"""Ticks into one live stream: the same entities, names and colours as in a saved file, as many rows as there are.

What a filter says of a reading comes with its tick: a reading is drawn at the elongation that it speaks for, which is
the filter's last estimate, grown by what the model grows in the tick, and the innovation.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimator.record import Array, Sample
from estimator.rig import Rig
from estimator.step import Step, Track
from viz.drawing import paths, series
from viz.drawing.entity import Entity
from viz.drawing.residuals import Residuals
from viz.drawing.series import Event
from viz.lanes.judged import Judged
from viz.lanes.lanes import Lanes
from viz.lanes.states import States
from viz.live.body import Body
from viz.live.minutes import Minutes
from viz.live.repeat import Repeated
from viz.live.room import Room
from viz.live.sure import Sure

READING = "displacement"  # the channel whose readings are drawn beside the elongation
LEAST_UM, LEAST_K = 5.0, 1.0  # height of a plot at least


class Rows:
    """What one stream shows.

    newest    whether the newest tick of each batch gets a picture of profile and screw
    window_s  what the time axes show, s
    """

    def __init__(self, at: Entity, rig: Rig, newest: bool, window_s: float) -> None:
        self._at, self._rig, self._window_s = at, rig, window_s
        self._lengths = np.flatnonzero(~rig.is_thermometer)
        self._minutes, self._body, self._status = Minutes(at, rig), Body(at, rig, newest), Repeated[str]()
        often_s = min(60.0, window_s / 2)
        (curve,) = series.OPEN_LOOP.items()
        self._elongation = Room(at / paths.ELONGATION, *curve, LEAST_UM, often_s)
        names, colours = paths.channel_names(rig, "°C"), series.channel_colours(len(rig.thermometers))
        self._temperatures = [
            (Room(at / plot, names[group][0], colours[group][0], LEAST_K, often_s), group)
            for plot, group in paths.thermometer_groups(rig).items()
        ]
        self._last = np.full(2, np.nan)  # elongation by the filter and by the model alone, um
        self._dot = np.full((1, 3), np.nan)  # time and value of the reading drawn last, and whether it was used
        self._fused = np.zeros(len(self._lengths), dtype=int)
        self._time_s, self._lanes = 0.0, Lanes(at)
        self._sure = Sure(at, READING)
        self._states, self._again = States(rig), Repeated[None]()
        series.style(at, rig, series.OPEN_LOOP)

    def send(
        self, ticks: Sequence[tuple[Sample, Step]], happened: Sequence[Event | Judged], status: str | None
    ) -> None:
        """Send what has come since the last time."""
        if ticks:
            self._ticks(ticks)
        for judged in (each for each in happened if isinstance(each, Judged)):
            self._lanes.send(judged)
        if events := [each for each in happened if isinstance(each, Event)]:
            series.send_events(self._at, events)
        if status is not None and self._status.due(status, self._time_s):
            (self._at / paths.STATUS).text(status, self._time_s)

    def end(self) -> None:
        """Send what waits for its minute to be over, or has not lasted yet."""
        self._minutes.end()
        self._lanes.follow(self._states.end())

    def _ticks(self, ticks: Sequence[tuple[Sample, Step]]) -> None:
        samples, steps = zip(*ticks, strict=True)
        track = Track.of(steps, np.empty(0), ())
        self._time_s = float(track.time_s[-1])
        series.send_track(self._at, self._rig, track)
        (self._at / paths.ELONGATION / "models").known(track.time_s, track.open_loop_um)
        band = 2 * track.sigma_um
        self._elongation.hold(self._time_s, [track.elongation_um - band, track.elongation_um + band])
        self._readings(samples, track)
        heat = self._rig.is_thermometer
        self._minutes.send(Residuals.of(track, heat))
        self._body.send(samples, track)
        for sample, step in ticks:
            self._lanes.follow(self._states.tick(sample, step))
        if self._again.due(None, self._time_s):
            self._lanes.follow(self._states.again())
        fused = np.where(track.fused, track.measured, np.nan)[:, heat]
        for room, group in self._temperatures:
            room.hold(self._time_s, [fused[:, group]])

    def _readings(self, samples: Sequence[Sample], track: Track) -> None:
        """Innovations of lengths, but for the first reading of each, which sets its zero."""
        fused = track.fused[:, self._lengths]
        before = self._fused + np.cumsum(fused, axis=0) - fused
        self._fused = self._fused + fused.sum(axis=0)
        innovation = np.where(before > 0, track.innovation[:, self._lengths], np.nan)
        known = np.isfinite(innovation).any(axis=1)
        (self._at / paths.DISPLACEMENT).curves(track.time_s[known], innovation[known])
        now = np.stack([track.elongation_um, track.open_loop_um], axis=-1)
        last = np.concatenate([self._last[None], now[:-1]])
        self._last = now[-1]
        if READING in self._rig.channels:
            column = np.flatnonzero(self._lengths == self._rig.index(READING))[0]
            sd = track.innovation_sd[:, self._lengths][:, column]
            self._sure.send(samples, track, np.where(fused[:, column], innovation[:, column], np.nan), sd)
            readings = last[:, 0] + now[:, 1] - last[:, 1] + innovation[:, column]
            self._dots(track.time_s, readings, fused[:, column])

    def _dots(self, time_s: Array, readings_um: Array, used: Array) -> None:
        """Readings far enough apart from the one drawn last; one that is impossible does not stretch the plot."""
        extent = self._elongation.hold(self._time_s, [readings_um[used]])
        if extent is None:
            return
        rows = np.concatenate([self._dot, np.stack([time_s, readings_um, used], axis=-1)])
        shown = series.spaced(rows[:, 0], rows[:, 1], (0.0, self._window_s), extent)
        if len(shown):
            self._dot = rows[shown[-1:]]
        drawn = rows[shown[shown > 0]]
        series.send_readings(self._at, drawn[:, 0], drawn[:, 1], drawn[:, 2] > 0)
