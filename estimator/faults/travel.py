"""Whether position and speed go together: a table moves no further than the screw turns, and moves while it turns.

    path  speed x time x lead of this tick or the one before, the longer: the most that the position can change by

A table that turns back within a tick moves less: a jump that is shorter than the path of a tick is not seen. Where a
drive begins or ends the mean speed of the tick hangs on when in it that was: on a fast bus nobody knows.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from estimator.record import Recording
from estimator.rig import Rig

SLACK_MM, SLACK = 5.0, 0.1  # of the path: both are read at slightly other times
STANDS_MM = 1e-3  # less is no motion
IN_A_ROW = 3  # ticks


def disagreements(recording: Recording, rig: Rig) -> Iterator[tuple[float, str]]:
    """What is wrong with position and speed of a recording, and since when, s."""
    travel, before = Travel(rig), ""
    position = recording.inputs.get("position", np.full(len(recording), np.nan))
    for time_s, place, omega in zip(recording.time_s, position, recording.omega):
        travel.step(place, omega)
        if travel.why and travel.why != before:
            yield float(time_s), travel.why
        before = travel.why


class Travel:
    """Takes position and speed tick by tick; `why` says what is wrong with them, empty: nothing."""

    def __init__(self, rig: Rig) -> None:
        given = rig.screw is not None and "position" in rig.inputs and "speed" in rig.inputs
        self._path = rig.screw.lead_mm / (2 * np.pi) * rig.tick_s if given and rig.screw else np.nan
        self._last, self._before, self._offset, self._slips, self._stands = np.nan, 0.0, 0.0, 0, 0

    @property
    def why(self) -> str:
        """What is wrong; a jump stays so until the position is back where it must be."""
        if self._slips >= IN_A_ROW:
            return "the position moves further than the speed says"
        if self._stands >= IN_A_ROW:
            return "the position stands still though the speed says that the screw turns"
        return f"the position jumped by {self._offset:+.1f} mm" if self._offset else ""

    def step(self, position_mm: float, omega: float) -> None:
        """One tick: the position at its close, and the mean of |speed| over it, rad/s."""
        path, moved = self._path * omega, position_mm - self._last
        before, self._before, self._last = self._before, path, position_mm
        if not np.isfinite(path + moved):
            return
        most = (1.0 + SLACK) * max(path, before) + abs(path - before) + SLACK_MM
        slips = abs(moved) > most
        self._slips = self._slips + 1 if slips else 0
        if slips:
            offset = self._offset + moved
            self._offset = offset if abs(offset) > most else 0.0
        self._stands = self._stands + 1 if path > SLACK_MM and abs(moved) < STANDS_MM else 0
