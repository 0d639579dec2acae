"""Profile and screw of a live stream, on axes that grow.

Which ticks get a picture: one every 10 s of the run's time, as in a saved file, so that a run played fast can be looked
through afterwards; and, for whoever looks on, the newest tick of each batch, which is every tick of a rig of 1 Hz and
never more than the batches of a second of wall time, however fast a run is played.
"""

from collections.abc import Sequence

import numpy as np

from estimator.record import Sample
from estimator.rig import Rig
from estimator.step import Track
from viz.drawing import body, profile, screw
from viz.drawing.entity import Entity
from viz.drawing.frames import Axes
from viz.drawing.scale import BodyScale, Indices
from viz.live.repeat import Repeated
from viz.live.scale import Growing

LEAST_K, LEAST_UM = 5.0, 20.0  # of the first ranges
NONE_YET = BodyScale((0.0, 1.0), (0.0, 1.0))


def frame_of(rig: Rig, scale: BodyScale = NONE_YET) -> Axes:
    """The profile's frame, which stands in the same place of its view whatever the ranges are."""
    return profile.axes_of(rig, scale).grounded()


class Body:
    """What has been drawn of profile and screw; `newest`: whether the newest tick of each batch gets a picture."""

    def __init__(self, at: Entity, rig: Rig, newest: bool) -> None:
        self._at, self._rig, self._newest = at, rig, newest
        self._on_screw = np.isfinite(profile.places_mm(rig))
        self._temperature, self._growth = Growing(LEAST_K), Growing(LEAST_UM)
        self._scale = Repeated[BodyScale]()
        self._piece = -np.inf  # of 10 s, the last one with a picture
        self._begun = False
        if rig.screw is not None:
            profile.style(at, rig, frame_of(rig), truth=False)

    def send(self, samples: Sequence[Sample], track: Track) -> None:
        """Send pictures of some of these ticks; none without a screw, or before the filter has started."""
        if self._rig.screw is None:
            return
        shown = self._shown(track)
        if not len(shown):
            return
        if not self._begun:
            self._begun = True
            screw.style(self._at, self._rig, track.profile_C.shape[1])
        scale = self._held(track, shown)
        body.send(self._at, self._rig, frame_of(self._rig, scale), scale, track, shown)
        position_mm = np.array([samples[k].inputs.get("position", np.nan) for k in shown])
        axes = frame_of(self._rig)  # the nut stands on the x axis, which does not change
        body.send_nut(self._at, self._rig, axes, track.time_s[shown], position_mm)

    def _shown(self, track: Track) -> Indices:
        shown = profile.picture_ticks(track.time_s, track.profile_C)
        pieces = np.floor(track.time_s[shown] / profile.PICTURE_S)
        shown = shown[pieces > self._piece]
        self._piece = max([self._piece, *pieces])
        known = np.isfinite(track.profile_C).all(axis=1) & (track.profile_C.shape[1] > 0)
        return np.union1d(shown, np.flatnonzero(known)[-1:]).astype(np.intp) if self._newest else shown

    def _held(self, track: Track, shown: Indices) -> BodyScale:
        """Ranges that hold these ticks, drawn anew where they have grown."""
        mean, sd = track.profile_C[shown], track.profile_sd_K[shown]
        measured = np.where(track.fused, track.measured, np.nan)[shown][:, self._on_screw]
        temperature = self._temperature.hold([mean - 2 * sd, mean + 2 * sd, measured])
        growth = self._growth.hold([track.elongation_um[shown], np.zeros(1)])
        assert temperature is not None
        assert growth is not None
        scale = BodyScale(temperature, growth)
        begin = float(track.time_s[shown[0]])
        if self._scale.due(scale, begin):
            profile.frame(self._at, self._rig, frame_of(self._rig, scale), begin)
            screw.bar_labels(self._at, self._rig, scale, begin)
        return scale
