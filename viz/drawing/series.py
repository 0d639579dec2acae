"""Curves over time: elongation and its error, temperatures and innovations of the channels.

One vector of Scalars for a group, never an entity for each channel. Aggregation keeps spikes: MinMax for innovations,
Max for NIS.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
import rerun as rr

from estimator.record import Array
from estimator.rig import Rig
from estimator.step import Track
from viz.drawing import paths
from viz.drawing.columns import Indices, thermometers
from viz.drawing.scale import Range, coloured

Aggregation = Literal["Average", "Max", "MinMax", "Off"]

POLYLINE = {"polyline [µm]": paths.POLYLINE}
OPEN_LOOP = {"open-loop [µm]": paths.OPEN_LOOP}
DENSE = 0.9  # a reference known at this share of the ticks is drawn as a line, else as points
SPACING = 0.03  # of the plot, between readings drawn


def style(rec: rr.RecordingStream, root: str, rig: Rig, models: Mapping[str, paths.Colour]) -> None:
    """Log names, units and colours of what every run has, once; `models` are drawn beside the filter."""
    at = f"{root}/{paths.ELONGATION}"
    band(rec, f"{at}/filter", "filter ±2 sd", paths.FILTER)
    lines(rec, f"{at}/models", list(models), list(models.values()), 1.5)
    dots(rec, f"{at}/readings", "readings [µm]", paths.READING, 3.0)
    rainbow = channel_colours(len(rig.thermometers))
    for plot, columns in paths.thermometer_groups(rig).items():
        lines(rec, f"{root}/{plot}", paths.channel_names(rig, "°C")[columns], rainbow[columns], 1.0)
    lines(rec, f"{root}/{paths.INNOVATIONS}", paths.channel_names(rig, "K"), rainbow, 1.0, "MinMax")
    lengths = [f"{name} [µm]" for name in rig.names if name not in rig.thermometers]
    dots(rec, f"{root}/{paths.DISPLACEMENT}", lengths, paths.READING, 2.5)


def style_reference(rec: rr.RecordingStream, root: str, reference: str, dense: bool) -> None:
    """Log the same of a reference and of the errors against it, once."""
    at = f"{root}/{paths.ELONGATION}"
    if dense:
        lines(rec, f"{at}/reference", [f"{reference} [µm]"], [paths.REFERENCE], 1.0)
    else:
        dots(rec, f"{at}/reference", f"reference: {reference} [µm]", paths.REFERENCE, 1.5)
    band(rec, f"{root}/{paths.ERROR}/filter", f"{reference} − filter ±2 sd", paths.FILTER, aggregation="MinMax")
    for name, colour in (("smoothed", paths.SMOOTHED), ("polyline", paths.POLYLINE)):
        lines(rec, f"{root}/{paths.ERROR}/{name}", [f"{reference} − {name} [µm]"], [colour], 1.5, "MinMax")


def lines(
    rec: rr.RecordingStream,
    at: str,
    names: Sequence[str],
    colours: Sequence[Sequence[int]],
    width: float,
    aggregation: Aggregation = "Average",
) -> None:
    """Log how the lines of one entity look."""
    looks = rr.SeriesLines(
        names=list(names), colors=colours, widths=[width] * len(names), aggregation_policy=aggregation
    )
    rec.log(at, looks, static=True)


def band(
    rec: rr.RecordingStream,
    at: str,
    name: str,
    colour: Sequence[int],
    width: float = 2.0,
    aggregation: Aggregation = "Average",
) -> None:
    """Log how a line of lengths with its band looks."""
    looks = rr.Measurements.from_fields(
        names=name, units="µm", colors=colour, widths=width, aggregation_policy=aggregation
    )
    rec.log(at, looks, static=True)


def dots(rec: rr.RecordingStream, at: str, names: str | Sequence[str], colour: Sequence[int], size: float) -> None:
    """Log how the points of one entity look."""
    looks = rr.SeriesPoints(names=names, colors=colour, markers="circle", marker_sizes=size)
    rec.log(at, looks, static=True)


def channel_colours(count: int) -> list[list[int]]:
    """One colour for each thermometer, free end blue, motor side red."""
    return coloured(np.arange(count), (0.0, max(count - 1.0, 1.0)))[:, :3].tolist()


def spaced(time_s: Array, values: Array, time_extent: Range, extent: Range) -> Indices:
    """Indices of the points to draw: known ones, each a step of the plot away from the one before.

    All readings would be a thick line that hides the curves.
    """
    across, up = time_extent[1] - time_extent[0], extent[1] - extent[0]
    kept: list[int] = []
    for k in np.flatnonzero(np.isfinite(values)):
        last = kept[-1] if kept else None
        if last is None or (time_s[k] - time_s[last]) / across + abs(values[k] - values[last]) / up > SPACING:
            kept.append(int(k))
    return np.array(kept, dtype=np.intp)


def send(rec: rr.RecordingStream, at: str, time_s: Array, values: Array) -> None:
    """Log n rows of one group, if there are any: times (n,) s, values (n, m). An empty chunk makes the viewer panic."""
    if not len(time_s):
        return
    index = [rr.TimeColumn(paths.TIMELINE, duration=time_s)]
    rec.send_columns(at, indexes=index, columns=rr.Scalars.columns(scalars=values))


def send_track(rec: rr.RecordingStream, root: str, rig: Rig, track: Track) -> None:
    """Log elongation by the filter, temperatures and innovations of the thermometers."""
    heat = thermometers(rig)
    send_band(rec, f"{root}/{paths.ELONGATION}/filter", track.time_s, track.elongation_um, track.sigma_um)
    for plot, columns in paths.thermometer_groups(rig).items():
        send(rec, f"{root}/{plot}", track.time_s, track.measured[:, heat][:, columns])
    send(rec, f"{root}/{paths.INNOVATIONS}", track.time_s, track.innovation[:, heat])


def send_known(rec: rr.RecordingStream, at: str, time_s: Array, values: Array) -> None:
    """Log one series (n,) where it is known."""
    known = np.isfinite(values)
    send(rec, at, time_s[known], values[known])


def send_band(rec: rr.RecordingStream, at: str, time_s: Array, mean: Array, sd: Array) -> None:
    """Log a line (n,) with a band of two standard deviations; the viewer draws one root of the variance."""
    known = np.isfinite(mean) & np.isfinite(sd)
    if not known.any():
        return
    index = [rr.TimeColumn(paths.TIMELINE, duration=time_s[known])]
    columns = rr.Measurements.columns(values=mean[known], variances=(2 * sd[known]) ** 2)
    rec.send_columns(at, indexes=index, columns=columns)
