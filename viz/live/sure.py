"""How sure the filter is while a run goes on: what it predicts of the displacement, within two standard deviations."""

from collections.abc import Sequence

import numpy as np

from estimator.inputs.phase import EARLY_S, turns
from estimator.record import Array, Sample
from estimator.step import Track
from viz.drawing import bars, paths
from viz.drawing.entity import Entity
from viz.drawing.scale import extent_of, labelled
from viz.drawing.views import LOW
from viz.live.repeat import Repeated
from viz.live.scale import Room
from viz.recorded.sure import PARTS, share_bars

EVERY_S = 60.0
SD = "filter [µm]"
LEAST_UM, LEAST_SD_UM = 1.0, 0.2  # the plots hold at least so much


class Sure:
    """Innovations of one length, and how many of them have been inside two sd, by what the machine was doing."""

    def __init__(self, at: Entity, channel: str) -> None:
        error = f"{channel} − prediction [µm]"
        self._at, self._due = at, Repeated[None](EVERY_S)
        self._inside, self._all = np.zeros((2, len(PARTS)))
        self._driven, self._stop_s = False, -np.inf
        (at / paths.SURE / "band").band("±2 sd of one reading", paths.BAND_EDGE, 0.5)
        (at / paths.SURE / "error").dots(error, paths.REFERENCE, 2.0)
        (at / paths.SURE / "outside").dots("outside [µm]", paths.LEFT_OUT, 3.0)
        (at / paths.SURE_SD / "filter").lines([SD], [paths.FILTER], 1.5)
        self._room = Room(at / paths.SURE, error, paths.REFERENCE, LEAST_UM, EVERY_S)
        self._sd_room = Room(at / paths.SURE_SD, SD, paths.FILTER, 0.0, EVERY_S)

    def send(self, samples: Sequence[Sample], track: Track, innovation: Array, sd: Array) -> None:
        """Take ticks with the innovations (n,) um of the channel and their sd, NaN where nothing was read."""
        (self._at / paths.SURE_SD / "filter").known(track.time_s, track.sigma_um)
        known, inside = np.isfinite(innovation), np.abs(innovation) <= 2 * sd
        curve, now_s = self._at / paths.SURE, float(track.time_s[-1])
        settled = np.where(known.cumsum() + self._all.sum() > 0, sd, np.nan)  # before, the zero is not known at all
        half = extent_of(np.abs(innovation), 2 * settled)[1]
        self._room.hold(now_s, [np.array(labelled((-half, half), LOW))])
        most = max(LEAST_SD_UM, extent_of(track.sigma_um)[1])
        self._sd_room.hold(now_s, [np.array(labelled((0.0, most), LOW))])
        (curve / "band").banded(track.time_s, np.zeros(len(sd)), settled)
        (curve / "error").curves(track.time_s[known], innovation[known])
        (curve / "outside").curves(track.time_s[known & ~inside], innovation[known & ~inside])
        for k, sample in enumerate(samples):
            part = self._part(sample)
            if known[k]:
                self._all[part] += 1
                self._inside[part] += inside[k]
        if self._all.any() and self._due.due(None, now_s):
            self._log(now_s)

    def _part(self, sample: Sample) -> int:
        """What the machine is doing, as a row of PARTS."""
        driving = bool(turns(sample.omega))
        if self._driven and not driving:
            self._stop_s = sample.time_s
        self._driven = driving
        return 0 if driving else 1 if 0 <= sample.time_s - self._stop_s <= EARLY_S else 2

    def _log(self, now_s: float) -> None:
        found = np.divide(self._inside, self._all, out=np.full(len(PARTS), np.nan), where=self._all > 0)
        shares = {"all": float(self._inside.sum() / self._all.sum()), **dict(zip(PARTS.values(), found, strict=True))}
        bars.send(self._at / paths.SURE_BARS, share_bars(shares), now_s)
