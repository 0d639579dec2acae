"""One thing that began within a run."""

from dataclasses import dataclass

HOT, DRIVING, PART, READING, LOOSE = "heat", "heat_driving", "effect", "reading", "loose"
EXCHANGED, GROWING = "exchanged", "growing"  # which are there all the time of a recording


@dataclass(frozen=True)
class Event:
    """Something that was not there before a time, and was from there on.

    run      recording;   since_s, sd_s  when, s since its first frame;   until_s: None to the end
    began_s  of the recording, s since 1970; None where its clock tells no date
    phase    whether the screw turned then, and for how long it had turned or stood, s; None: it was so all the time
    kind     "heat", "heat_driving" (while the screw turns), "effect" (a part of the model grew or shrank), "reading"
             (a shift), "loose" (a thermometer that shows less of its rise), "exchanged" (the plugs of `channel` and
             `name`), "growing" (a part, from recording to recording)
    from_mm, to_mm  where, None for a body (`name`) and for a part of the model (`name`)
    channel  which reads wrong
    heat_W, sd_W    mean from then on, positive: the model lacks it;   share: by which a part of the model grew, or by
                    which a thermometer shows more of its rise
    offset   of a reading, in its unit
    gain     twice the log-likelihood that it adds
    what     a person should know, and the next step
    """

    run: str
    since_s: float
    sd_s: float
    kind: str
    until_s: float | None = None
    began_s: float | None = None
    from_mm: float | None = None
    to_mm: float | None = None
    name: str | None = None
    channel: str | None = None
    heat_W: float | None = None
    sd_W: float | None = None
    share: float | None = None
    offset: float | None = None
    gain: float = 0.0
    phase: tuple[bool, float] | None = None
    what: str = ""

    def told(self, clock: str = "", until: str = "") -> str:
        """CS-10.blf: from 13:42 on (4310 s, +- 3 min) it heats.

        clock, until  local time of its beginning and end, if known; else both are since the recording's start
        """
        if self.kind in (EXCHANGED, GROWING):
            return f"{self.run}: {self.what}."
        seconds = f"{self.since_s:.0f} s" if self.until_s is None else f"{self.since_s:.0f} - {self.until_s:.0f} s"
        start = "" if clock else " after its start"
        since = clock or _after(self.since_s)
        span = f"{since}{start} on" if self.until_s is None else f"{since} to {until or _after(self.until_s)}{start}"
        return f"{self.run}: from {span} ({seconds}, +- {max(self.sd_s / 60.0, 1.0):.0f} min) {self.what}."


def _after(seconds: float) -> str:
    """1 h 12 min"""
    hours, minutes = divmod(round(seconds / 60.0), 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min"
