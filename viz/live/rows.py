"""Ticks into one live stream: the same entities, names and colours as in a saved file, as many rows as there are."""

from collections.abc import Sequence

import numpy as np

from estimator.record import Sample
from estimator.rig import Rig
from estimator.step import Step, Track
from viz.drawing import paths, profile, series
from viz.drawing.entity import Entity
from viz.drawing.residuals import Residuals
from viz.drawing.series import Event
from viz.lanes import banner
from viz.lanes.lanes import Lanes
from viz.lanes.standing import Glance, Judged, Standing
from viz.lanes.states import States
from viz.live.body import Body
from viz.live.minutes import Minutes
from viz.live.readings import READING, Readings
from viz.live.repeat import Repeated
from viz.live.scale import Room
from viz.live.sure import Sure
from viz.live.table import Table

LEAST_UM, LEAST_K = 5.0, 1.0  # height of a plot at least


class Rows:
    """What one stream shows.

    newest    whether somebody looks on: the newest tick of each batch gets a picture of profile and screw, and what is
              so now a banner
    window_s  what the time axes show, s
    """

    def __init__(self, at: Entity, rig: Rig, newest: bool, window_s: float) -> None:
        self._at, self._rig = at, rig
        self._lengths = np.flatnonzero(~rig.is_thermometer)
        self._minutes, self._body = Minutes(at, rig), Body(at, rig, newest)
        self._words, self._glances, self._looked_at = Repeated[str](), Repeated[tuple[Glance, ...]](), newest
        often_s = min(60.0, window_s / 2)
        (curve,) = series.OPEN_LOOP.items()
        self._elongation = Room(at / paths.ELONGATION, *curve, LEAST_UM, often_s)
        names, colours = paths.channel_names(rig, "°C"), series.channel_colours(len(rig.thermometers))
        self._temperatures = [
            (Room(at / plot, names[group][0], colours[group][0], LEAST_K, often_s), group)
            for plot, group in paths.thermometer_groups(rig).items()
        ]
        self._shown = Readings(at, rig, window_s) if READING in rig.channels else None
        self._fused = np.zeros(len(self._lengths), dtype=int)
        self._time_s, self._lanes = 0.0, Lanes(at)
        self._sure = Sure(at, READING)
        stroke, rest_s = rig.stroke_mm, 0.0 if newest else profile.PICTURE_S
        self._table = Table(at, rig, stroke, often_s, rest_s) if stroke else None
        self._states, self._again = States(rig), Repeated[None]()
        series.style(at, rig, series.OPEN_LOOP)

    def send(
        self, ticks: Sequence[tuple[Sample, Step]], happened: Sequence[Event | Judged], standing: Standing | None
    ) -> None:
        """Send what has come since the last time."""
        judged = [each for each in happened if isinstance(each, Judged)]
        if self._table is not None:
            self._table.judge(judged)
        if ticks:
            self._ticks(ticks)
        for each in judged:
            self._lanes.send(each)
        if events := [each for each in happened if isinstance(each, Event)]:
            series.send_events(self._at, events)
        if standing is not None:
            self._stands(standing)

    def end(self) -> None:
        """Send what waits for its minute to be over, or has not lasted yet."""
        self._minutes.end()
        self._lanes.follow(self._states.end())

    def _stands(self, standing: Standing) -> None:
        """How things stand, where that is another than was sent last."""
        if self._words.due(standing.words, standing.time_s):
            (self._at / paths.STATUS).text(standing.words, standing.time_s)
        if self._looked_at and self._glances.due(standing.glances, standing.time_s):
            banner.send(self._at / paths.BANNER, standing.glances, standing.time_s)
        if self._table is not None and standing.table is not None:
            self._table.send_stroke(standing.time_s, standing.table)

    def _ticks(self, ticks: Sequence[tuple[Sample, Step]]) -> None:
        samples, steps = zip(*ticks, strict=True)
        track = Track.of(steps, np.empty(0), ())
        self._time_s = float(track.time_s[-1])
        series.send_track(self._at, self._rig, track)
        (self._at / paths.ELONGATION / "models").known(track.time_s, track.open_loop_um)
        band = 2 * track.sigma_um
        self._elongation.hold(self._time_s, [track.elongation_um - band, track.elongation_um + band])
        self._readings(samples, track)
        if self._table is not None:
            self._table.send(track)
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
        if self._shown is not None:
            column = np.flatnonzero(self._lengths == self._rig.index(READING))[0]
            sd, used = track.innovation_sd[:, self._lengths][:, column], fused[:, column]
            self._sure.send(samples, track, np.where(used, innovation[:, column], np.nan), sd)
            um = self._shown.values(track, innovation[:, column])
            if (
                extent := self._elongation.hold(self._time_s, [um[used]])
            ) is not None:  # impossible ones do not stretch
                self._shown.send(track, um, extent)
            self._shown.send_dial(samples, track)
