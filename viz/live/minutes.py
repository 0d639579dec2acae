"""Maps and tests of the innovations in a live stream: a minute at a time, each sent when it is over."""

from dataclasses import fields

import numpy as np

from estimator.rig import Rig
from viz.drawing import paths, residuals
from viz.drawing.entity import Entity
from viz.drawing.frames import colour_bar
from viz.drawing.residuals import Residuals
from viz.drawing.scale import MINUTE_S, minutes
from viz.live.scale import Decades, Room

COLOURS = -1.0, 1.0  # ends of the scale of decades
SHORT_S = 1e-3  # a stripe ends so much before the next begins: two rows of one time confuse the viewer's colours
NIS_RANGE = 0.0, 2.0  # at least


class Minutes:
    """The open minute of a stream; those before have been sent."""

    def __init__(self, at: Entity, rig: Rig) -> None:
        self._at = at
        self._open: Residuals | None = None
        self._begin_s = np.nan  # of the first minute that has not been sent
        self._scale: Decades | None = None
        residuals.style(at, rig)
        self._nis = Room(at / paths.NIS, *residuals.NIS, least=0.0, every_s=0.0)

    def send(self, ticks: Residuals) -> None:
        """Take ticks, and send the minutes that are over."""
        if self._open is None:
            self._open, self._begin_s = ticks, float(ticks.time_s[0])
        else:
            self._open = _joined(self._open, ticks)
        minute = np.floor((self._open.time_s - self._begin_s) / MINUTE_S)
        over = int(np.searchsorted(minute, minute[-1]))
        if over:
            self._close(_rows(self._open, slice(0, over)))
            self._open = _rows(self._open, slice(over, None))

    def end(self) -> None:
        """Send the open minute as it is."""
        if self._open is not None:
            self._close(self._open)
            self._open = None

    def _close(self, ticks: Residuals) -> None:
        residuals.send_tests(self._at, ticks, self._begin_s)
        if self._scale is None and np.isfinite(ticks.innovation_sd).any():
            self._scale = Decades.of(ticks.innovation_sd)  # of both maps, from now on
            for bar in paths.MAPS.values():
                colour_bar(self._at / bar, COLOURS, self._scale.labels)
        for drawn, values in ticks.mapped().items():
            begins, means = minutes(ticks.time_s, values, first_s=self._begin_s)
            stripes = np.append(begins, begins[-1] + MINUTE_S - SHORT_S)
            means = np.concatenate([means, means[-1:]])
            shades = self._scale.shares(means) if self._scale else np.full_like(means, np.nan)
            residuals.send_map(self._at / drawn, stripes, shades, COLOURS)
        self._nis.hold(begins[-1], [np.array(NIS_RANGE)])
        self._begin_s = begins[-1] + MINUTE_S


def _joined(before: Residuals, after: Residuals) -> Residuals:
    pairs = [(getattr(before, field.name), getattr(after, field.name)) for field in fields(Residuals)]
    return Residuals(*(np.concatenate(pair) for pair in pairs))


def _rows(ticks: Residuals, which: slice) -> Residuals:
    return Residuals(*(getattr(ticks, field.name)[which] for field in fields(Residuals)))
