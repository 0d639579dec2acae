"""What is in a recording, signal by signal, before anybody has said what it is; and what it is taken as."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from drivers.frames import Array
from estimator.rig import Signal

_ODD = 0.5  # % of the values at either end that may be sentinels


@dataclass(frozen=True, eq=False)
class Seen:
    """A signal of a recording.

    source  "Message.Signal", or the column of a CSV
    unit    as the DBC or the CSV says it, "" where nothing does
    time    (n,) s     value  (n,) in that unit; readings only
    raw     (n,) numbers on the wire, of a signal of a DBC
    texts   of its value table, by raw number
    parts   where each recording begins, of several
    """

    source: str
    unit: str
    time: Array
    value: Array
    raw: Array = field(default_factory=lambda: np.empty(0))
    texts: Mapping[int, str] = field(default_factory=dict)
    parts: tuple[int, ...] = (0,)

    @property
    def message(self) -> str:
        """The message that carries it; "" in a CSV."""
        return self.source.partition(".")[0] if len(self.raw) else ""

    @property
    def label(self) -> str:
        """Its name in the message, or the column."""
        return self.source.partition(".")[2] if len(self.raw) else self.source

    @property
    def place(self) -> tuple[str | tuple[str, ...], str | None]:
        """Where rig.toml finds it: the signal of a DBC, or the column of a CSV."""
        return (self.source, None) if self.message else ((), self.source)

    @cached_property
    def step_s(self) -> float:
        """The usual time from one reading to the next, s; infinite for a single one."""
        return float(np.median(np.diff(self.time))) if len(self.time) > 1 else np.inf

    @cached_property
    def rate_hz(self) -> float:
        """Readings a second, over all its time."""
        return (len(self.time) - 1) / span if len(self.time) > 1 and (span := float(np.ptp(self.time))) else 0.0

    @cached_property
    def usual(self) -> tuple[float, float]:
        """Its range without rare sentinels."""
        low, high = np.percentile(self.value, (_ODD, 100 - _ODD))
        return float(low), float(high)

    @property
    def width(self) -> float:
        """How far apart the ends of that range are."""
        return self.usual[1] - self.usual[0]

    @cached_property
    def middle(self) -> float:
        """Its median."""
        return float(np.median(self.value))

    def after(self, other: "Seen") -> "Seen":
        """The same signal of two recordings as one, this behind the other, by times that go on from one to the next."""
        return replace(
            self,
            time=np.concatenate((other.time, self.time)),
            parts=(*other.parts, *(len(other.time) + part for part in self.parts)),
            value=np.concatenate((other.value, self.value)),
            raw=np.concatenate((other.raw, self.raw)),
        )


@dataclass(frozen=True)
class Guess:
    """What signals of a recording are taken as: an entry of rig.toml, and why.

    name     of the channel or input       role    "thermometer", "speed", "ambient" ...: what a model makes of it
    seen     the signal, or several that are added up
    rule     how it stands in rig.toml, without its place
    why      in words                      also    other signals that it might be
    """

    name: str
    role: str
    seen: tuple[Seen, ...]
    rule: Signal
    why: str
    also: tuple[Seen, ...] = ()

    @property
    def value(self) -> Array:
        """In the unit of rig.toml, (n,)."""
        return self.rule.scale * np.sum([one.value for one in self.seen], axis=0) + self.rule.offset

    @property
    def time(self) -> Array:
        """When, (n,) s."""
        return self.seen[0].time


def behind_each_other(recordings: Sequence[Sequence[Seen]]) -> Iterable[Seen]:
    """The signals of all recordings, each recording behind the one before."""
    seen: dict[str, Seen] = {}
    end = 0.0
    for signals in recordings:
        begin = min(float(one.time[0]) for one in signals)
        for one in signals:
            later = replace(one, time=one.time - begin + end)
            seen[one.source] = later.after(seen[one.source]) if one.source in seen else later
        end = max(float(one.time[-1]) for one in seen.values()) + 1.0
    return seen.values()


def named_apart(guesses: Sequence[Guess]) -> Iterator[Guess]:
    """Of two with one name the second is called so with a number."""
    taken: set[str] = set()
    for guess in guesses:
        number = next(k for k in range(1, len(guesses) + 2) if _numbered(guess.name, k) not in taken)
        yield replace(guess, name=_numbered(guess.name, number))
        taken.add(_numbered(guess.name, number))


def _numbered(name: str, number: int) -> str:
    return f"{name}_{number}" if number > 1 else name
