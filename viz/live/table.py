"""The error at the table, which is what a control compensates: over time where the table is, and over its stroke.

What was sent to the control is drawn where it was sent as valid, and nowhere else.
"""

from collections.abc import Sequence

import numpy as np
import rerun as rr

from estimator.record import Array
from estimator.rig import Rig
from estimator.step import TableErrors, Track
from viz.drawing import paths, profile
from viz.drawing.entity import Entity
from viz.drawing.frames import Axes
from viz.drawing.scale import Range, extent_of
from viz.lanes.standing import Judged
from viz.live.repeat import Repeated
from viz.live.scale import Growing, Room

WIDE, HIGH, LINE = 1000.0, 430.0, 34.0  # view units: the frame, and a line of text
LEAST_UM = 5.0  # the axes hold at least so much
SENT = "sent to the control"
CURVE = "error at the table ±2 sd"
KEY = (
    ("error were the table there, ±2 sd", paths.FILTER),
    ("travelled", paths.NUT),
    ("at the table now", paths.REFERENCE),
    (SENT, paths.SENT),
)


def axes_of(stroke_mm: Range, um: Range = (0.0, 1.0)) -> Axes:
    """The frame, which stands in the same place of its view whatever the range of errors is."""
    return Axes(stroke_mm, um, WIDE, HIGH, LINE).grounded()


class Table:
    """What one stream shows of a rig whose table has an error; `rest_s`: between pictures of the stroke at least."""

    def __init__(self, at: Entity, rig: Rig, stroke_mm: Range, often_s: float, rest_s: float) -> None:
        self._curve, self._place, self._stroke, self._rest_s = at / paths.TABLE, at / paths.STROKE, stroke_mm, rest_s
        self._extent, self._drawn = Growing(LEAST_UM), Repeated[Range]()
        self._travelled, self._now, self._picture_s = (np.nan, np.nan), (np.nan, np.nan), -np.inf
        self._changes = [(-np.inf, False)]
        (self._curve / "filter").band(CURVE, paths.FILTER)
        (self._curve / "sent").dots(f"{SENT} [µm]", paths.SENT, 1.5)
        self._room = Room(self._curve, f"{CURVE} [µm]", paths.FILTER, LEAST_UM, often_s)
        axes_of(stroke_mm).key(self._place / "axes/key", KEY)
        profile.style_banded(self._place)

    def judge(self, judged: Sequence[Judged]) -> None:
        """Take whether the estimate is sent, from times on."""
        for each in judged:
            before = [change for change in self._changes if change[0] <= each.time_s]  # all but those of another run
            self._changes = [*before, (each.time_s, each.published == "sent")]

    def send(self, track: Track) -> None:
        """Log ticks over time, after what was judged of them."""
        error, sd, position = track.error_at_table_um, track.error_at_table_sd_um, track.position_mm
        self._room.hold(float(track.time_s[-1]), [error - 2 * sd, error + 2 * sd])
        (self._curve / "filter").banded(track.time_s, error, sd)
        (self._curve / "sent").known(track.time_s, np.where(self._sent(track.time_s), error, np.nan))
        self._now = float(position[-1]), float(error[-1])
        if (known := np.isfinite(position)).any():
            self._travelled = extent_of(position[known], np.array(self._travelled))

    def _sent(self, time_s: Array) -> Array:
        """Whether the estimate was sent as valid at times (n,)."""
        begins, sent = zip(*self._changes, strict=True)
        at = np.searchsorted(begins, time_s, side="right") - 1
        del self._changes[: at[-1]]
        return np.array(sent)[at]

    def send_stroke(self, time_s: float, table: TableErrors) -> None:
        """Log what the error would be wherever the table were."""
        error, sd = table.error_um, table.sd_um
        extent = self._extent.hold([error - 2 * sd, error + 2 * sd, np.zeros(1)])
        if not np.isfinite(error).all() or extent is None or 0 <= time_s - self._picture_s < self._rest_s:
            return
        self._picture_s, axes = time_s, axes_of(self._stroke, extent)
        if self._drawn.due(extent, time_s):
            axes.draw(self._place / "axes", "position of the table [mm]", y_unit=" µm", x_pieces=10, since_s=time_s)
        profile.send_banded(self._place, axes, table.at_mm, np.array([time_s]), error, sd)
        self._marks(axes, time_s)

    def _marks(self, axes: Axes, time_s: float) -> None:
        """Where the table has been, where it is, and whether that is sent."""
        points, (at_mm, um) = rr.Radius.ui_points, self._now
        if np.isfinite(um):
            bar = rr.LineStrips2D([axes.place(self._travelled, axes.y[0])], radii=points(3.5), colors=paths.NUT)
            (self._place / "travelled").log(bar, time_s)
            colour = paths.SENT if self._changes[-1][1] else paths.REFERENCE
            (self._place / "now").log(
                rr.Points2D(axes.place([at_mm], [um]), radii=points(6.0), colors=colour, draw_order=30.0), time_s
            )
