"""What a run tells over time: elongation and its error, temperatures and innovations as curves, what is wrong as lanes,
events in words.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr

from estimator.alarms.alarms import Alarm
from estimator.record import Array
from estimator.rig import Rig
from estimator.step import Track
from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.drawing.scale import Indices, Range, coloured

POLYLINE = {"polyline [µm]": paths.POLYLINE}
OPEN_LOOP = {"open-loop [µm]": paths.OPEN_LOOP}
DENSE = 0.9  # a reference known at this share of the ticks is drawn as a line, else as points
SPACING = 0.03  # of the plot, between readings drawn


def style(at: Entity, rig: Rig, models: Mapping[str, paths.Colour]) -> None:
    """Log names, units and colours of what every run has, once; `models` are drawn beside the filter."""
    length, heat, rainbow = at / paths.ELONGATION, rig.thermometers, channel_colours(len(rig.thermometers))
    (length / "filter").band("filter ±2 sd", paths.FILTER)
    (length / "models").lines(list(models), list(models.values()), 1.5)
    (length / "readings").dots("readings [µm]", paths.READING, 3.0)
    for plot, columns in paths.thermometer_groups(rig).items():
        (at / plot).lines(paths.channel_names(rig, "°C")[columns], rainbow[columns], 1.0)
    (at / paths.INNOVATIONS).lines(paths.channel_names(rig, "K"), rainbow, 1.0, "MinMax")
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


def send_track(at: Entity, rig: Rig, track: Track) -> None:
    """Log elongation by the filter, temperatures and innovations of the thermometers."""
    heat = rig.is_thermometer
    (at / paths.ELONGATION / "filter").banded(track.time_s, track.elongation_um, track.sigma_um)
    for plot, columns in paths.thermometer_groups(rig).items():
        (at / plot).curves(track.time_s, track.measured[:, heat][:, columns])
    (at / paths.INNOVATIONS).curves(track.time_s, track.innovation[:, heat])


@dataclass(frozen=True)
class Event:
    """One sentence at a time; level is INFO or WARN."""

    time_s: float
    text: str
    level: str = "INFO"


def clock(time_s: float) -> str:
    """Time since the start as h:mm:ss."""
    minutes, seconds = divmod(round(time_s), 60)
    return f"{minutes // 60}:{minutes % 60:02d}:{seconds:02d}"


def send_events(at: Entity, events: Sequence[Event]) -> None:
    """Log events of a run, in words."""
    texts = [f"{clock(event.time_s)}  {event.text}" for event in events]
    columns = rr.TextLog.columns(text=texts, level=[event.level for event in events])
    (at / paths.EVENTS).rows([event.time_s for event in events], columns)


ESTIMATE, VALID = "estimate", "valid"  # the lane that is always there, and what it says while all is well
FEW = 6  # channels that are named one by one


@dataclass(frozen=True)
class Judged:
    """Why the estimate is not to be relied on from a time on, empty where it is, and the alarms that are on."""

    time_s: float
    why: tuple[str, ...]
    alarms: tuple[Alarm, ...]

    @property
    def states(self) -> dict[str, tuple[str, float]]:
        """What each lane says and since when, s: whether the estimate is valid, which channels are stuck, and so on."""
        states = {ESTIMATE: (", ".join(self.why) or VALID, self.time_s)}
        for kind in {alarm.kind for alarm in self.alarms if alarm.channel}:
            own = [alarm for alarm in self.alarms if alarm.kind == kind]
            names = sorted({alarm.channel for alarm in own})
            shown = ", ".join(names) if len(names) <= FEW else f"{len(names)} channels: {names[0]} ... {names[-1]}"
            states[f"{paths.FAULTS}/{kind.replace(' ', '_')}"] = shown, min(alarm.since_s for alarm in own)
        return states


class Lanes:
    """Whether to rely on the estimate, and below it a lane for each kind of alarm that channels have had."""

    def __init__(self, at: Entity) -> None:
        self._at = at / paths.STATE
        self._last: dict[str, tuple[str, float]] = {}
        self._colours: dict[str, dict[str, paths.Colour]] = {}

    def send(self, judged: Judged) -> None:
        """Log the states: what begins, from when on it has been so, never before what the lane said last."""
        none = {lane: ("", judged.time_s) for lane, (text, _) in self._last.items() if text}
        for lane, (text, since_s) in {**none, **judged.states}.items():
            before, from_s = self._last.get(lane, ("", -np.inf))
            time_s = judged.time_s if before else min(max(since_s, from_s), judged.time_s)
            self._style(lane, text)
            (self._at / lane).rows([time_s], rr.StateChange.columns(state=[text]))
            self._last[lane] = text, time_s

    def _style(self, lane: str, text: str) -> None:
        """Log the colours of a lane anew where it says what it never said before."""
        colours = self._colours.setdefault(lane, {"": paths.BACKGROUND})
        if text not in colours:
            colours[text] = paths.VALID if text == VALID else paths.LEFT_OUT
            looks = rr.StateConfiguration(values=list(colours), colors=list(colours.values()))
            (self._at / lane).log(looks)
