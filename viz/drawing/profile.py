"""The temperature profile along the screw: estimate with its band, measured points, the truth where it is known.

x is drawn in mm as it is. The band is a comb of upright strokes, because a 2D view has no transparency.
"""

from collections.abc import Sequence

import numpy as np
import rerun as rr

from estimator.record import Array
from estimator.rig import Rig
from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.drawing.frames import Axes
from viz.drawing.scale import BodyScale, Flags, Indices, Range

PICTURE_S = 10.0  # profile and screw are kept every 10 s, curves at every tick
MOST_PICTURES = 3000  # of a run: eight hours of them
IN_CHUNK = 120
ASPECT = 0.46  # height of the frame over its width
KEY = (
    ("estimate ±2 sd", paths.FILTER),
    ("thermometer", paths.MEASURED),
    ("not fused", paths.LEFT_OUT),
    ("nut", paths.NUT),
    ("bearings", paths.BOUND),
    ("truth", paths.REFERENCE),
)
LINE = 0.035  # a line of text over the width of the frame


def axes_of(rig: Rig, scale: BodyScale) -> Axes:
    """The frame: the whole screw, and all temperatures of the run."""
    screw = rig.the_screw()
    width = screw.to_mm - screw.from_mm
    return Axes((screw.from_mm, screw.to_mm), scale.temperature_C, width, ASPECT * width, LINE * width)


def picture_ticks(time_s: Array, profile_C: Array) -> Indices:
    """Indices of the first tick with a profile in each 10 s, of a long run in a multiple of that."""
    known = np.flatnonzero(np.isfinite(profile_C).all(axis=1) & (profile_C.shape[1] > 0))
    if not len(known):
        return known
    every_s = PICTURE_S * max(1.0, np.ceil((time_s[-1] - time_s[0]) / (PICTURE_S * MOST_PICTURES)))
    return known[np.unique(np.floor(time_s[known] / every_s), return_index=True)[1]]


def pieces(shown: Indices) -> list[Indices]:
    """Ticks of pictures in pieces, each for a chunk of its own: to check a chunk takes the square of its curves."""
    return np.array_split(shown, -(-len(shown) // IN_CHUNK))


def places_mm(rig: Rig) -> Array:
    """Where the channels are on the screw, (m,) mm; NaN for one that is not on it."""
    return np.array([np.nan if c.at_mm is None else c.at_mm for c in rig.channels.values()])


def style(at: Entity, rig: Rig, axes: Axes, truth: bool) -> None:
    """Log the key and the looks of lines and points, once."""
    at, points = at / paths.PROFILE, rr.Radius.ui_points
    absent = {"nut": rig.nut is None, "bearings": not rig.supports, "truth": not truth}
    axes.key(at / "axes/key", [entry for entry in KEY if not absent.get(entry[0])])
    lines, dots = rr.LineStrips2D.from_fields, rr.Points2D.from_fields
    style_banded(at)
    (at / "measured").log(dots(radii=points(4.5), draw_order=30.0))
    (at / "faults").log(dots(radii=0.0, colors=paths.LEFT_OUT, show_labels=True, draw_order=32.0))
    (at / "truth").log(dots(radii=points(2.2), colors=paths.REFERENCE, draw_order=31.0))
    (at / "nut").log(lines(radii=points(3.5), colors=paths.NUT, draw_order=3.0))


def style_banded(at: Entity) -> None:
    """Log the looks of a curve with its band, once."""
    lines, points = rr.LineStrips2D.from_fields, rr.Radius.ui_points
    edges = [paths.FILTER, paths.BAND_EDGE, paths.BAND_EDGE]
    (at / "estimate").log(lines(radii=points([1.8, 0.6, 0.6]), colors=edges, draw_order=2.0))
    (at / "band").log(lines(radii=points(0.7), colors=paths.BAND, draw_order=1.0))


def frame(at: Entity, rig: Rig, axes: Axes, since_s: float | None = None) -> None:
    """Log axes and bearings."""
    at = at / paths.PROFILE
    axes.draw(at / "axes", "place x [mm]", y_unit=" °C", x_pieces=12, since_s=since_s)
    if rig.supports:
        send_bars(at / "bearings", axes, bearings_mm(rig), paths.BOUND, since_s)


def bearings_mm(rig: Rig) -> list[Range]:
    """From where to where each bearing is, mm."""
    return [(s.at_mm - s.width_mm / 2, s.at_mm + s.width_mm / 2) for s in rig.supports.values()]


def send_bars(
    at: Entity, axes: Axes, spans: Sequence[Range], colour: paths.Colour, since_s: float | None = None
) -> None:
    """Log bars on the x axis, from where to where, mm."""
    bars = [axes.place(span, axes.y[0]) for span in spans]
    at.log(rr.LineStrips2D(bars, radii=rr.Radius.ui_points(3.5), colors=colour, draw_order=2.5), since_s)


def send(at: Entity, axes: Axes, time_s: Array, mean: Array, sd: Array) -> None:
    """Log n profiles from end to end: times (n,) s, means and standard deviations (n, x)."""
    send_banded(at / paths.PROFILE, axes, np.linspace(*axes.x, mean.shape[1]), time_s, mean, sd)


def send_banded(at: Entity, axes: Axes, x: Array, time_s: Array, mean: Array, sd: Array) -> None:
    """Log n curves over places x, with their bands: times (n,) s, means and standard deviations (n, x)."""
    n = len(time_s)
    strips = axes.place(x, np.stack([mean, mean + 2 * sd, mean - 2 * sd], axis=1)).astype(np.float32)
    lines = rr.LineStrips2D.columns(strips=strips.reshape(3 * n, -1, 2)).partition(np.full(n, 3)) if n else ()
    (at / "estimate").rows(time_s, lines)
    band = axes.place(np.repeat(x, 2), comb(mean - 2 * sd, mean + 2 * sd)).astype(np.float32)
    (at / "band").rows(time_s, rr.LineStrips2D.columns(strips=band))


def comb(low: Array, high: Array) -> Array:
    """One stroke that goes up at one place and down at the next: (n, x) twice -> (n, 2 x)."""
    pairs = np.stack([low, high], axis=-1)
    pairs[:, 1::2] = pairs[:, 1::2, ::-1]
    return pairs.reshape(len(low), -1)


def send_measured(at: Entity, axes: Axes, time_s: Array, at_mm: Array, values: Array, fused: Flags) -> None:
    """Log measured temperatures (n, m) at places (m,), each in the colour of whether it was fused (n, m)."""
    known = np.isfinite(values + at_mm)
    colours = np.where(fused[known][:, None], paths.MEASURED, paths.LEFT_OUT).astype(np.uint8)
    columns = rr.Points2D.columns(positions=axes.place(at_mm, values)[known].astype(np.float32), colors=colours)
    (at / paths.PROFILE / "measured").rows(time_s, columns.partition(known.sum(axis=1)))


def send_faults(at: Entity, axes: Axes, time_s: Array, at_mm: Array, values: Array, said: Array) -> None:
    """Log what is wrong with thermometers in words (n, m), "" for nothing, at measured temperatures (n, m)."""
    broken = np.isfinite(values + at_mm) & (said != "")
    places = axes.place(at_mm, values)[broken].astype(np.float32)
    columns = rr.Points2D.columns(positions=places, labels=said[broken].tolist())
    (at / paths.PROFILE / "faults").rows(time_s, columns.partition(broken.sum(axis=1)))


def send_truth(at: Entity, axes: Axes, time_s: Array, at_mm: Array, values: Array) -> None:
    """Log true temperatures (n, m) at places (m,)."""
    known = np.isfinite(values + at_mm)
    points = rr.Points2D.columns(positions=axes.place(at_mm, values)[known].astype(np.float32))
    (at / paths.PROFILE / "truth").rows(time_s, points.partition(known.sum(axis=1)))


def send_nut(at: Entity, axes: Axes, rig: Rig, time_s: Array, position_mm: Array) -> None:
    """Log where the nut is (n,), as a bar on the x axis."""
    middle, half = rig.the_nut().centre(position_mm), rig.the_nut().length_mm / 2
    ends = np.stack([middle - half, middle + half], axis=-1)
    bars = rr.LineStrips2D.columns(strips=axes.place(ends, axes.y[0]).astype(np.float32))
    (at / paths.PROFILE / "nut").rows(time_s, bars)
