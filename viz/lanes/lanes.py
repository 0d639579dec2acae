"""Lanes into a stream: what is judged of the estimate and the channels, and what is so at each tick.

A lane of a channel is there from when the channel is first anything but used: fifteen that say the same hide one that
does not.
"""

from collections.abc import Iterable

import numpy as np
import rerun as rr

from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.lanes.standing import Judged
from viz.lanes.states import State

USED = "used"


class Lanes:
    """The lanes of one run, logged as they change."""

    def __init__(self, at: Entity) -> None:
        self._at = at
        self._last: dict[str, tuple[str, float]] = {}
        self._well: dict[str, State] = {}
        self._colours: dict[str, dict[str, paths.Colour]] = {}

    def send(self, judged: Judged) -> None:
        """Log the states: what begins, from when on it has been so, never before what the lane said last."""
        none = {lane: ("", judged.time_s) for lane, (text, _) in self._last.items() if text}
        for lane, (text, since_s) in {**none, **judged.states}.items():
            before, from_s = self._last.get(lane, ("", -np.inf))
            time_s = judged.time_s if before else min(max(since_s, from_s), judged.time_s)
            self._log(f"{paths.STATE}/{lane}", text, time_s)
            self._last[lane] = text, time_s

    def follow(self, states: Iterable[State]) -> None:
        """Log what has changed at a tick."""
        for state in states:
            quiet = state.lane.startswith(f"{paths.CHANNELS}/") and state.lane not in self._colours
            if quiet and state.text == USED:
                self._well.setdefault(state.lane, state)
                continue
            for each in filter(None, (self._well.pop(state.lane, None), state)):
                self._log(each.lane, each.text, each.since_s)

    def _log(self, lane: str, text: str, time_s: float) -> None:
        """Log a state, and the colours of its lane anew where it says what it never said before."""
        colours = self._colours.setdefault(lane, {"": paths.BACKGROUND})
        if text not in colours:
            colours[text] = paths.lane_colour(lane, text)
            looks = rr.StateConfiguration(values=list(colours), colors=list(colours.values()))
            (self._at / lane).log(looks)
        (self._at / lane).rows([time_s], rr.StateChange.columns(state=[text]))
