"""What can be wrong with a channel, what is seen of the channels, and what is made of it."""

from dataclasses import dataclass, fields
from enum import IntEnum

import numpy as np

from estimator.record import Array

MINUTE_S, FORGOTTEN_S = 60.0, 1000.0  # of the thermometers' innovations

LED_SDS, LED_UM = 5.0, 0.4  # by less no length is said to have led; 3.6 sd at most on machines 0 - 14

MAY_DRIFT = "may drift"  # of a channel that is fused
ELSEWHERE = "the nut's heat is not where the position says"


class Fault(IntEnum):
    """Why a channel is not fused. One that is judged has just jumped, alone or with others: soon more will be known."""

    NONE = 0
    JUDGED = 1
    STUCK = 2
    JUMPED = 3
    LOOSE = 4
    DRIFTING = 5
    OFF = 6
    APART = 7

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
    Fault.APART: "grows otherwise than the thermometers say",
}


@dataclass(frozen=True)
class Led:
    """K ticks: how far lengths have led the elongation from what thermometers alone say, and how well these know it.

    um     (K,)
    var    (K,) um^2, of the elongation by thermometers alone;   doubt (K, p) um, how that moves with each parameter
    minute (K,) square of the thermometers' innovations, as a share of what it should be, the mean of a minute
    worse  (K,) how many times as large as they should be they have been, at least 1, forgotten in a quarter of an hour
    """

    um: Array
    var: Array
    doubt: Array
    minute: Array
    worse: Array

    def __getitem__(self, some: slice) -> "Led":
        """Some of the ticks."""
        return Led(*(getattr(self, field.name)[some] for field in fields(self)))

    def __len__(self) -> int:
        return len(self.um)

    @property
    def far(self) -> Array:
        """Whether that is so far that lengths may be wrong, if the model's parameters are right, (K,)."""
        return np.asarray(np.abs(self.um) > np.maximum(LED_UM, LED_SDS * self.worse * np.sqrt(self.var)))

    def worsened(self, nis: Array, tick_s: float) -> tuple[Array, Array]:
        """`minute` and `worse` of ticks after these, by the square of a thermometer's innovation, (K,)."""
        gain, kept = 1.0 - np.exp(-tick_s / MINUTE_S), np.exp(-tick_s / FORGOTTEN_S)
        mean, worse, found = float(self.minute[-1]), float(self.worse[-1]), []
        for now in nis.tolist():
            mean += gain * (now - mean) if now == now else 0.0
            worse = max(1.0, mean**0.5, kept * worse)
            found.append((mean, worse))
        minute, times = np.array(found).T
        return minute, times

    @classmethod
    def nowhere(cls, ticks: int, p: int) -> "Led":
        """Nothing has been led yet, or there is no length."""
        none, usual = np.zeros(ticks), np.ones(ticks)
        return cls(none, none, np.zeros((ticks, p)), usual, usual)

    def later(self, before: "Led") -> "Led":
        """Of ticks after these, the tick before each, which `before` is of the first: (K,)."""
        return Led.joined(before, self)[: len(self)]

    @classmethod
    def joined(cls, first: "Led", then: "Led") -> "Led":
        """Ticks that follow each other, as one."""
        return cls(*(np.concatenate([getattr(one, field.name) for one in (first, then)]) for field in fields(cls)))


@dataclass(frozen=True)
class Seen:
    """K ticks of m channels, in K or um, before anything of them is fused.

    time_s   (K,)
    reading  (K, m) NaN: not measured
    value    (K, m) innovation;   sd  (K, m) of it, inf: no model
    alone    (K, m) reading by the model alone
    muted    (K, m) bool
    doubt    (K, m, p) how the model alone moves with each of its parameters that are in doubt
    led        of the tick before each
    astray     (K,) bool, whether heat is in the wrong place: neither neighbours nor lengths tell of each other
    driven     (K,) bool, whether the screw has turned since the run began
    """

    time_s: Array
    reading: Array
    value: Array
    sd: Array
    alone: Array
    muted: Array
    doubt: Array
    led: Led
    astray: Array
    driven: Array

    def first(self, ticks: int) -> "Seen":
        """The first of the ticks."""
        return Seen(*(getattr(self, field.name)[:ticks] for field in fields(self)))


@dataclass(frozen=True)
class Judgement:
    """K ticks, as far as all but the last were without an event.

    fault    (K, m) a Fault each, since when (K, m) s
    may_drift_K  (K, m) by how much channels that are fused may have drifted, 0: not suspected; since when in since_s
    lacks_K    (K, m) by how much channels depart from the others by heat that the model lacks, 0: they do not
    departs_K  (K, m) by how much others do, as models lack in detail, 0: they do not
    off_share  (K,) by which share of their values the model's parameters must be off, 0: as a fit has left them
    shift_mm   (K,) by how much the nut's heat stands elsewhere than the position says, 0: it does not
    jump     (m,) by how much channels jumped whose zero is now another one; None: none did
    drift    (m,) by how much channels had drifted that were fused up to now; None: none had
    heated   (m,) bool, which of those only read heat that the model lacks: their zeros are what they were; None: none
    loose    (m,) by how much more channels may have drifted that go on being fused; None: none by more than was said
    apart    whether lengths are left out from now on, and all that they have said is forgotten
    anew     whether the run has to begin again with the last tick: what it began with were no temperatures
    """

    fault: Array
    since_s: Array
    may_drift_K: Array
    lacks_K: Array
    departs_K: Array
    off_share: Array
    shift_mm: Array
    jump: Array | None = None
    drift: Array | None = None
    heated: Array | None = None
    loose: Array | None = None
    apart: bool = False
    anew: bool = False


@dataclass(frozen=True)
class Tick:
    """One tick, compared: each (m,).

    read       read and not muted
    known      whether its level is known
    deviation  of the innovation from its level, with its limit;   beyond  further than that
    repeats    how often a thermometer has read the same, or a length, by how unlikely that is
    moved      by what the reading has changed since it was last well, NaN: it never was
    """

    time_s: float
    read: Array
    known: Array
    deviation: Array
    limit: Array
    beyond: Array
    repeats: Array
    moved: Array


@dataclass(frozen=True)
class Spell:
    """A time in which a channel or an input was broken: how most of it, from when to when, s; NaN where it lasts."""

    fault: Fault
    from_s: float
    to_s: float


@dataclass(frozen=True)
class Suspicion:
    """A time in which a channel that may have drifted was used: by how much at most, K, and when, as a Spell."""

    most_K: float
    from_s: float
    to_s: float


def spells(fault: Array, since_s: Array, time_s: Array) -> tuple[Spell, ...]:
    """When something was broken, by its faults (K,); what was only held for a while was not."""
    found = []
    for first, end in spans(fault != Fault.NONE):
        broken = fault[first:end][fault[first:end] > Fault.JUDGED]
        if len(broken):
            most = Fault(int(np.bincount(broken).argmax()))
            to_s = float(time_s[end]) if end < len(fault) else float("nan")
            found.append(Spell(most, float(np.nanmin(since_s[first:end])), to_s))
    return tuple(found)


def suspicions(may_drift_K: Array, fault: Array, time_s: Array) -> tuple[Suspicion, ...]:
    """When a channel was used though it may have drifted, by its ticks (K,); what became a fault is told as that."""
    ends, broken = np.append(time_s, np.nan), fault > Fault.JUDGED
    return tuple(
        Suspicion(float(max(may_drift_K[first:end], key=abs)), float(time_s[first]), float(ends[end]))
        for first, end in spans(may_drift_K != 0)
        if not broken[end : end + 1].any()
    )


def spans(so: Array) -> Array:
    """First tick and end of each time in which something is so, (spans, 2)."""
    return np.flatnonzero(np.diff(np.concatenate([[0], so, [0]]))).reshape(-1, 2)
