"""Whether the estimate is to be relied on, the alarms that are on, and whether it is sent, from a time on."""

from __future__ import annotations

from dataclasses import dataclass

from estimator.alarms.alarms import Alarm
from viz.drawing import paths

VALID = "valid"  # what the lane of the estimate says while all is well
FEW = 6  # channels that are named one by one


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
