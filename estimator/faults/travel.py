"""Whether position and speed go together: a table moves no further than the screw turns, and moves while it turns.

    path  mean speed x time x lead of this tick or the one before, the longer: the most that the position can change by;
          the time is that of the tick and at most of the last reading before it

A table that turns back within a tick moves less: a jump that is shorter than the path of a tick is not seen so, but
from one frame to the next. Where a drive begins or ends the mean speed of the tick hangs on when in it that was: on a
fast bus nobody knows.

    pace  how far the position moves as a share of what the speed says, by stretches in which that does not turn: 1

A position in inches, a speed in another scale are told by it within seconds, however often the table turns; and one
that runs the other way than before.

Where speeds are as far apart as ticks, or further, the axis can have started, stopped or turned between two of them:

    path  fastest speed read so far x time between the two x lead

and none as long as few speeds of a drive have been read. A drive that sends seldom at rest and often while it turns
would have told of a motion. What stood for ten readings, is elsewhere at the next and stands again has jumped or made
one move between two: which of both, nobody can say.
"""

import math
from collections import deque
from collections.abc import Iterator, Mapping
from itertools import repeat
from statistics import median
from typing import NamedTuple

import numpy as np

from estimator.cover import AT_ONCE
from estimator.record import Recording, Sample
from estimator.rig import RAD_S, Rig

SLACK_MM, SLACK = 5.0, 0.1  # of the path: both are read at slightly other times
STANDS_MM = 1e-3  # less is no motion
IN_A_ROW = 3  # ticks
LONG = 10  # readings
FEW = 20  # ticks that turn, whose speeds do not tell how fast the axis is; rows in each of which it moves unseen
PACED, PACE = 5, 0.85  # ticks that turn, over which the pace is looked at; least of it, and of one over it
UNSIGNED = 0.5  # the same where the speed has no sign
HEAT_S = 7200.0  # for which heat in a wrong place is felt
LONG_SILENCE = 7200  # ticks: heat that nothing was heard of is felt as long as that lasted, and no longer than this
FELT_S = 120.0  # after which thermometers alone have told of heat that was not known
QUICK = 0.5  # ticks: further apart, speeds do not tell how far the table moves between two


class Motion(NamedTuple):
    """What a tick tells of how the table moves, fields as in a Sample, which takes five times as long to make."""

    time_s: float
    omega: float
    pace: float
    apart_s: float
    slip_mm: float
    inputs: Mapping[str, float]


def motions(recording: Recording) -> Iterator[Motion]:
    """Those of all ticks."""
    names = [name for name in ("position", "speed") if name in recording.inputs]
    series = recording.time_s, recording.omega, recording.pace, recording.apart_s, recording.slip_mm
    for at in (slice(k, k + AT_ONCE) for k in range(0, len(recording), AT_ONCE)):
        told = zip(*(recording.inputs[name][at].tolist() for name in names), strict=True) if names else repeat(())
        yield from map(Motion, *(each[at].tolist() for each in series), (dict(zip(names, row)) for row in told))


def disagreements(recording: Recording, rig: Rig) -> Iterator[tuple[float, str]]:
    """What is wrong with position and speed of a recording, and since when, s."""
    travel, before = Travel(rig), ""
    for sample in motions(recording):
        travel.step(sample)
        if travel.why and travel.why != before:
            yield sample.time_s, travel.why
        before = travel.why


def too_slow(recording: Recording, rig: Rig) -> str:
    """Which jumps of the position are not seen for speeds that are too far apart; empty: none that matter."""
    turning, speed = recording.omega > 0, np.abs(recording.inputs.get("speed", np.empty(0)))
    read = turning & np.isfinite(recording.apart_s)
    if not {"position", "speed"} <= set(rig.inputs) or rig.screw is None or not read.any():
        return ""
    apart_s = float(np.median(recording.apart_s[read]))
    if apart_s < QUICK * rig.tick_s:
        return ""
    way_mm = apart_s * rig.screw.lead_mm / (2 * np.pi) * RAD_S[rig.inputs["speed"].unit] * float(np.nanmax(speed))
    return (
        f"speeds {apart_s:.3g} s apart are too slow to check the position: the table moves by up to {way_mm:.0f} mm "
        "between two, a shorter jump is not seen, and where the nut's heat goes is known as roughly"
    )


class Travel:
    """Takes position and speed tick by tick; `why` says what is wrong with them, empty: nothing."""

    def __init__(self, rig: Rig) -> None:
        self._given = rig.screw is not None and "position" in rig.inputs and "speed" in rig.inputs
        self._lead = rig.screw.lead_mm / (2 * np.pi) if rig.screw else np.nan
        self._rad_s, self._tick_s = RAD_S[rig.inputs["speed"].unit] if self._given else np.nan, rig.tick_s
        self._last, self._before, self._offset, self._slips, self._stands = np.nan, 0.0, 0.0, 0, 0
        self._fastest, self._turned, self._apart_s = 0.0, 0, np.inf
        self._stood, self._unseen, self._moves, self._untold = 0, 0.0, 0, 0
        self._silent = 0  # ticks without news of the drive, less those with
        self._paces, self._pace, self._signed, self._side = deque[float](maxlen=PACED), 0.0, False, 0.0
        self._wrong, self._wrong_s, self._now_s, self._against = "", -np.inf, 0.0, False

    @property
    def why(self) -> str:
        """What is wrong; a jump stays so until the position is back where it must be."""
        if self._moves >= FEW or math.isinf(self._pace):
            return "the position moves though the speed says that the screw stands"
        if self._slips >= IN_A_ROW:
            return "the position moves further than the speed says"
        if self._untold >= IN_A_ROW:
            return "the position is not told though the screw turns"
        if self._stands >= IN_A_ROW:
            return "the position stands still though the speed says that the screw turns"
        if self._pace:
            return (
                f"the position moves {self._pace:.2g} times as far as the speed says: check units, scales and lead_mm"
            )
        if self._against:
            return "the position moves the other way than before"
        if self._offset:
            return f"the position jumped by {self._offset:+.1f} mm"
        unseen = self._unseen and self._stood >= IN_A_ROW
        return f"the position moved by {self._unseen:+.1f} mm though the screw stood at every reading" if unseen else ""

    @property
    def lately(self) -> str:
        """What is wrong, or was within the last minutes."""
        return self.why or (self._wrong if self._now_s - self._wrong_s < FELT_S else "")

    @property
    def astray(self) -> bool:
        """Whether heat is in the wrong place, or was within the last hours; or nothing was heard of it for as long."""
        return self._now_s - self._wrong_s < HEAT_S or self._silent > 0

    def step(self, sample: Sample | Motion) -> None:
        """One tick."""
        self._follow(sample)
        self._now_s = sample.time_s
        silent = self._given and math.isnan(sample.omega)
        self._silent = min(self._silent + 1, LONG_SILENCE) if silent else max(self._silent - 1, 0)
        if self.why:
            self._wrong, self._wrong_s = self.why, sample.time_s

    def _follow(self, sample: Sample | Motion) -> None:
        """What position and speed say."""
        if not math.isnan(sample.pace) and sample.apart_s < QUICK / 2 * self._tick_s:
            self._keep_pace(sample)
        if not self._given or math.isnan(sample.apart_s):
            return
        place = sample.inputs["position"]
        path, moved = self._lead * sample.omega * (self._tick_s + sample.apart_s), place - self._last
        before, self._before, self._last = self._before, path, place
        self._learn(sample, turned=path > 0 and before > 0)
        self._untold = self._untold + 1 if math.isnan(place) and path > 0 else 0
        if not math.isfinite(path + moved):
            return
        usual = (1.0 + SLACK) * max(path, before) + abs(path - before) + SLACK_MM
        slow = self._slow(sample.apart_s)
        most = self._between(sample.apart_s) if slow else usual
        self._rest(moved, turns=path > 0 or not slow)
        slips = abs(moved) > most
        self._slips = self._slips + 1 if slips else 0
        told = math.isfinite(sample.slip_mm)
        if sample.slip_mm if told else slips:
            by, least = (sample.slip_mm, SLACK_MM) if told else (moved, most)
            offset = self._offset + by
            self._offset = offset if abs(offset) > least else 0.0
        self._stands = self._stands + 1 if path > SLACK_MM and abs(moved) < STANDS_MM else 0

    def _keep_pace(self, sample: Sample | Motion) -> None:
        """A speed without a sign hides where the table turns, and that it moved less then."""
        if not self._signed and sample.inputs["speed"] < 0.0:
            self._signed = True
            self._paces.clear()  # which way the table went is told from here on
        self._paces.append(sample.pace)
        known = len(self._paces) == PACED
        side, pace = np.sign(median(self._paces)), median(map(abs, self._paces)) if known else 1.0
        self._side = self._side or side * (known and self._signed)
        self._against = known and self._side * side < 0
        wrong = not (PACE if self._signed else UNSIGNED) < pace < 1.0 / PACE
        self._pace = (self._pace or pace) if wrong else 0.0

    def _learn(self, sample: Sample | Motion, turned: bool) -> None:
        """How fast the axis has been, and how often its speed is read while it turns."""
        speed = abs(self._rad_s * sample.inputs["speed"])
        self._fastest = speed if speed > self._fastest else self._fastest  # NaN is none
        if turned:
            self._turned, self._apart_s = self._turned + 1, min(self._apart_s, sample.apart_s)

    def _rest(self, moved: float, turns: bool) -> None:
        """How long the table has stood, and how far it moved in one step between two such times, mm."""
        self._moves = self._moves + 1 if not turns and abs(moved) > SLACK_MM else 0
        if turns:
            self._stood, self._unseen = 0, 0.0
        elif abs(moved) <= SLACK_MM:
            self._stood += 1
        else:
            unseen = self._unseen + moved if self._stood >= LONG else 0.0
            self._stood, self._unseen = 0, unseen if abs(unseen) > SLACK_MM else 0.0

    def _slow(self, apart_s: float) -> bool:
        """Whether the axis can have moved between two speeds that are so far apart, and none told of it."""
        return min(apart_s, self._apart_s) >= QUICK * self._tick_s

    def _between(self, apart_s: float) -> float:
        """The most that the table can move between two such speeds, mm."""
        return (1.0 + SLACK) * self._lead * self._fastest * apart_s + SLACK_MM if self._turned > FEW else np.inf
