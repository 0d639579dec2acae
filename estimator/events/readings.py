"""What the judge of the thermometers has told already: a zero that jumped, a channel that came loose or drifts."""

from __future__ import annotations

from collections.abc import Iterator

from estimator.events.event import READING, Event
from estimator.events.spans import SPAN_S
from estimator.faults.fault import Fault
from estimator.faults.sentences import place_of
from estimator.faults.use import Use
from estimator.record import Recording
from estimator.rig import Rig

FEW = 3  # channels that jump at once; more of them are the board's or the bus's


def of_readings(use: Use, recording: Recording, rig: Rig) -> Iterator[Event]:
    """Events of single channels that were left out, or whose readings go on from another zero."""
    begun = use.name, recording.began_s
    for jump in use.jumps:
        if len(jump.sizes) <= FEW:
            for channel, size in jump.sizes.items():
                yield _event(begun, jump.time_s, channel, rig, f"jumped by {size:+.2f}: its zero is another one", size)
    for one in use.suspects:
        for spell in one.spells:
            doubt = "; if it is well, heat is missing there" if spell.fault == Fault.DRIFTING else ""
            yield _event(begun, spell.from_s, one.channel, rig, f"{spell.fault.said}: check that sensor{doubt}")


def _event(
    begun: tuple[str, float | None], since_s: float, channel: str, rig: Rig, what: str, size: float | None = None
) -> Event:  # fmt: skip
    run, began_s = begun
    what = f"{place_of(rig, rig.index(channel))} {what}"
    return Event(run, since_s, SPAN_S / 2, READING, began_s=began_s, channel=channel, offset=size, what=what)
