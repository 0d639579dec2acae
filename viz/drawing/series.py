"""What a run tells over time: elongation and its error, temperatures and innovations as curves, events in words."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr

from estimator.record import Array
from estimator.rig import Rig
from estimator.step import Track
from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.drawing.scale import Indices, Range, clock, coloured

POLYLINE = {"polyline [µm]": paths.POLYLINE}
OPEN_LOOP = {"open-loop [µm]": paths.OPEN_LOOP}
DENSE = 0.9  # a reference known at this share of the ticks is drawn as a line, else as points
SPACING = 0.08  # of the plot, between readings drawn
USED_READINGS, UNUSED_READINGS, DIAL = "reading, used [µm]", "reading, not used [µm]", "dial at rest ±2 sd"


def style(at: Entity, rig: Rig, models: Mapping[str, paths.Colour]) -> None:
    """Log names, units and colours of what every run has, once; `models` are drawn beside the filter."""
    length, heat, rainbow = at / paths.ELONGATION, rig.thermometers, channel_colours(len(rig.thermometers))
    (length / "filter").band("filter ±2 sd", paths.FILTER)
    (length / "models").lines(list(models), list(models.values()), 1.5)
    (length / "readings").dots(USED_READINGS, paths.READING, 3.0)
    hollow = rr.SeriesPoints(
        names=[UNUSED_READINGS] * 2, colors=[paths.READING, paths.BACKGROUND], markers="circle", marker_sizes=[3.0, 1.8]
    )
    (length / "readings_unused").log(hollow)
    for plot, columns in paths.thermometer_groups(rig).items():
        (at / plot).lines(paths.channel_names(rig, "°C")[columns], rainbow[columns], 1.0)
    for plot, columns in paths.thermometer_groups(rig, paths.INNOVATIONS).items():
        (at / plot).lines(paths.channel_names(rig, "K")[columns], rainbow[columns], 1.0, "MinMax")
    (at / paths.DISPLACEMENT).dots([f"{name} [µm]" for name in rig.names if name not in heat], paths.READING, 2.5)


def style_reference(at: Entity, reference: str, dense: bool) -> None:
    """Log the same of a reference and of the errors against it, once."""
    if dense:
        (at / paths.ELONGATION / "reference").lines([f"{reference} [µm]"], [paths.REFERENCE], 1.0)
    else:
        (at / paths.ELONGATION / "reference").dots(f"reference: {reference} [µm]", paths.REFERENCE, 1.5)
    (at / paths.ERROR / "filter").band(f"{reference} − filter ±2 sd", paths.FILTER, aggregation="MinMax")
    for name, colour in (("smoothed", paths.SMOOTHED), ("polyline", paths.POLYLINE)):
        (at / paths.ERROR / name).lines([f"{reference} − {name} [µm]"], [colour], 1.5, "MinMax")


def channel_colours(count: int) -> list[list[int]]:
    """One colour for each thermometer: of those of one plot, the one nearest to the free end is darkest."""
    size = paths.in_plot(count)
    return coloured(np.arange(count) % size, (0.0, max(size - 1.0, 1.0)))[:, :3].tolist()


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


def send_readings(at: Entity, time_s: Array, um: Array, used: Array) -> None:
    """Log single readings of the elongation (n,): filled where the filter used them (n,), else hollow."""
    length = at / paths.ELONGATION
    (length / "readings").curves(time_s[used], um[used])
    (length / "readings_unused").curves(time_s[~used], np.stack([um[~used]] * 2, axis=-1))


def send_track(at: Entity, rig: Rig, track: Track) -> None:
    """Log elongation by the filter, temperatures and innovations of the thermometers."""
    heat = rig.is_thermometer
    (at / paths.ELONGATION / "filter").banded(track.time_s, track.elongation_um, track.sigma_um)
    for plot, columns in paths.thermometer_groups(rig).items():
        (at / plot).curves(track.time_s, track.measured[:, heat][:, columns])
    for plot, columns in paths.thermometer_groups(rig, paths.INNOVATIONS).items():
        (at / plot).curves(track.time_s, track.innovation[:, heat][:, columns])


@dataclass(frozen=True)
class Event:
    """One sentence at a time; level is INFO or WARN."""

    time_s: float
    text: str
    level: str = "INFO"


def send_events(at: Entity, events: Sequence[Event]) -> None:
    """Log events of a run, in words."""
    texts = [f"{clock(event.time_s)}  {event.text}" for event in events]
    columns = rr.TextLog.columns(text=texts, level=[event.level for event in events])
    (at / paths.EVENTS).rows([event.time_s for event in events], columns)
