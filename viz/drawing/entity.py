"""An entity: one place of a stream, how it looks there and what is logged.

Curves of a group are one vector of Scalars, never an entity for each channel. Aggregation keeps spikes: MinMax for
innovations, Max for NIS.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import rerun as rr
from numpy.typing import ArrayLike

from estimator.record import Array
from viz.drawing import paths
from viz.drawing.scale import Colours

Aggregation = Literal["Average", "Max", "MinMax", "Off"]


@dataclass(frozen=True)
class Entity:
    """A stream and a path in it; `entity / "name"` is one below it."""

    rec: rr.RecordingStream
    path: str = ""

    def __truediv__(self, name: str) -> "Entity":
        return Entity(self.rec, f"{self.path}/{name}")

    def log(self, what: Any, since_s: float | None = None) -> None:
        """Log something for all times, or from `since_s` on."""
        if since_s is not None:
            self.rec.set_time(paths.TIMELINE, duration=since_s)
        self.rec.log(self.path, what, static=since_s is None)

    def rows(self, time_s: ArrayLike, columns: Iterable[Any]) -> None:
        """Log n rows at times (n,) s, if there are any: an empty chunk makes the viewer panic."""
        time_s = np.asarray(time_s)
        if len(time_s):
            index = rr.TimeColumn(paths.TIMELINE, duration=time_s)
            self.rec.send_columns(self.path, indexes=[index], columns=columns)

    def lines(
        self, names: Sequence[str], colours: Sequence[Sequence[int]], width: float, aggregation: Aggregation = "Average"
    ) -> None:
        """How curves look as lines."""
        widths = [width] * len(names)
        self.log(rr.SeriesLines(names=list(names), colors=colours, widths=widths, aggregation_policy=aggregation))

    def dots(self, names: str | Sequence[str], colour: Sequence[int], size: float) -> None:
        """How curves look as points."""
        self.log(rr.SeriesPoints(names=names, colors=colour, markers="circle", marker_sizes=size))

    def band(
        self, name: str, colour: Sequence[int], width: float = 2.0, aggregation: Aggregation = "Average"
    ) -> None:  # fmt: skip
        """How a line of lengths with its band looks."""
        self.log(
            rr.Measurements.from_fields(
                names=name, units="µm", colors=colour, widths=width, aggregation_policy=aggregation
            )
        )

    def curves(self, time_s: Array, values: Array) -> None:
        """Rows of one group: times (n,) s, values (n, m)."""
        self.rows(time_s, rr.Scalars.columns(scalars=values) if len(time_s) else ())

    def known(self, time_s: Array, values: Array) -> None:
        """One curve (n,) where it is known."""
        known = np.isfinite(values)
        self.curves(time_s[known], values[known])

    def banded(self, time_s: Array, mean: Array, sd: Array) -> None:
        """A line (n,) with a band of two standard deviations; the viewer draws one root of the variance."""
        known = np.isfinite(mean) & np.isfinite(sd)
        if known.any():
            self.rows(time_s[known], rr.Measurements.columns(values=mean[known], variances=(2 * sd[known]) ** 2))

    def spans(self, time_s: Array, mean: Array, sd: Array) -> None:
        """The same in pieces, with a gap where it is not known."""
        known = np.isfinite(mean) & np.isfinite(sd)
        ends = known[:-1] & ~known[1:]
        kept = known | np.append(False, ends)  # the first that is not known ends a piece
        if known.any():
            variances = np.where(known, (2 * sd) ** 2, np.nan)[kept]
            self.rows(
                time_s[kept], rr.Measurements.columns(values=np.where(known, mean, np.nan)[kept], variances=variances)
            )

    def words(
        self,
        places: ArrayLike,
        texts: Sequence[str],
        colours: Sequence[paths.Colour] | None = None,
        since_s: float | None = None,
    ) -> None:
        """Labels at places (n, 2) in view units."""
        points = rr.Points2D(places, labels=list(texts), show_labels=True, radii=0.0, colors=colours or paths.TEXT)
        self.log(points, since_s)

    def picture(self, pixels: Colours, since_s: float | None = None) -> None:
        """A picture (height, width, 3), whose pixels stay sharp."""
        self.log(rr.Image(np.ascontiguousarray(pixels), magnification_filter="Nearest"), since_s)

    def text(self, markdown: str, since_s: float | None = None) -> None:
        """A page of text."""
        self.log(rr.TextDocument(markdown, media_type=rr.MediaType.MARKDOWN), since_s)
