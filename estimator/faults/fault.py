"""What can be wrong with a channel, what is seen of the channels, and what is made of it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import IntEnum

from estimator.record import Array

POWER_ON_C = (85.0, 0.0)  # what thermometers say that have not converted yet


class Fault(IntEnum):
    """Why a channel is not fused. One that is judged has just jumped, alone or with others: soon more will be known."""

    NONE = 0
    JUDGED = 1
    STUCK = 2
    JUMPED = 3
    LOOSE = 4
    DRIFTING = 5
    OFF = 6

    @property
    def word(self) -> str:
        """As it is printed; empty for a channel that is well or only judged."""
        return self.name.lower() if self > Fault.JUDGED else ""

    @property
    def said(self) -> str:
        """What is wrong with "T06 at 559 mm" ..."""
        return SAID.get(self, "")

    @property
    def why(self) -> str:
        """Why the reading was not fused; empty where it was."""
        return "implausible jump" if self == Fault.JUDGED else self.word


SAID = {
    Fault.STUCK: "is stuck",
    Fault.JUMPED: "has jumped",
    Fault.LOOSE: "is loose",
    Fault.DRIFTING: "drifts away from its neighbours",
    Fault.OFF: "has been off from the start",
}


@dataclass(frozen=True)
class Seen:
    """K ticks of m channels, in K or um, before anything of them is fused.

    time_s   (K,)
    reading  (K, m) NaN: not measured
    value    (K, m) innovation;   sd  (K, m) of it, inf: no model
    alone    (K, m) reading by the model alone
    muted    (K, m) bool
    doubt    (K, m, p) what the model alone may be off by, per standard normal error of its parameters
    """

    time_s: Array
    reading: Array
    value: Array
    sd: Array
    alone: Array
    muted: Array
    doubt: Array

    def first(self, ticks: int) -> Seen:
        """The first of the ticks."""
        return Seen(*(getattr(self, field.name)[:ticks] for field in fields(self)))


@dataclass(frozen=True)
class Judgement:
    """K ticks, as far as all but the last were without an event.

    fault    (K, m) a Fault each, since when (K, m) s
    jump     (m,) by how much channels jumped whose zero is now another one; None: none did
    drift    (m,) by how much channels had drifted that were fused up to now; None: none had
    anew     whether the run has to begin again with the last tick: what it began with were no temperatures
    """

    fault: Array
    since_s: Array
    jump: Array | None = None
    drift: Array | None = None
    anew: bool = False


@dataclass(frozen=True)
class Tick:
    """One tick, compared: each (m,).

    read       read and not muted
    known      whether its level is known
    deviation  of the innovation from its level, with its limit;   beyond  further than that
    repeats    how often a thermometer has read the same
    """

    time_s: float
    read: Array
    known: Array
    deviation: Array
    limit: Array
    beyond: Array
    repeats: Array
