"""How things stand at a moment, at a glance and in words; whether the estimate is to be relied on, from a time on."""

from dataclasses import dataclass
from typing import Literal

from estimator.alarms.alarms import Alarm
from estimator.step import TableErrors
from viz.drawing import paths

VALID = "valid"  # what the lane of the estimate says while all is well
FEW = 6  # channels that are named one by one
Tone = Literal["value", "valid", "invalid", "stale"]  # stale: grey, for nobody may take it for a value of now


@dataclass(frozen=True)
class Glance:
    """One value in large letters, what it is above it, and since when or why below it."""

    caption: str
    value: str
    below: str
    tone: Tone


@dataclass(frozen=True)
class Standing:
    """What is so at a time.

    glances  what is read from across the room
    words    everything else, as markdown
    table    the error at the table, were it anywhere on its stroke; None where there is no such thing, or it is old
    """

    time_s: float
    glances: tuple[Glance, ...]
    words: str
    table: TableErrors | None = None


@dataclass(frozen=True)
class Judged:
    """Why the estimate is not to be relied on from a time on, empty where it is, and the alarms that are on.

    published  whether it is sent to a control and why not; "" where nobody could have asked for it
    """

    time_s: float
    why: tuple[str, ...]
    alarms: tuple[Alarm, ...]
    published: str = ""

    @property
    def states(self) -> dict[str, tuple[str, float]]:
        """What each lane says and since when, s: whether the estimate is valid, which channels are stuck, and so on."""
        states = {paths.ESTIMATE: (", ".join(self.why) or VALID, self.time_s)}
        if self.published:
            states[paths.PUBLISHED] = self.published, self.time_s
        if whole := [alarm for alarm in self.alarms if not alarm.channel]:
            text = ", ".join(sorted({alarm.kind for alarm in whole}))
            states[paths.ALARMS] = text, min(alarm.since_s for alarm in whole)
        for kind in {alarm.kind for alarm in self.alarms if alarm.channel}:
            own = [alarm for alarm in self.alarms if alarm.kind == kind]
            names = sorted({alarm.channel for alarm in own})
            shown = ", ".join(names) if len(names) <= FEW else f"{len(names)} channels: {names[0]} ... {names[-1]}"
            states[f"{paths.FAULTS}/{kind.replace(' ', '_')}"] = shown, min(alarm.since_s for alarm in own)
        return states
