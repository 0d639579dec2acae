"""What the judge of the thermometers has told already: a zero that jumped, a channel that came loose or drifts.

One that shows a share less of its rise drifts from its neighbours in a drive and comes back to them at rest: it has
come loose. None shows less than nothing of it. And two plugs exchanged: each of two thermometers shows what the other's
place would by the model alone. A model whose heat is in the wrong place makes two thermometers at either end of it look
so too, but not only these.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain, combinations

import numpy as np

from estimator.events.event import EXCHANGED, LOOSE, READING, Event
from estimator.events.signature import AsRead
from estimator.events.spans import SPAN_S
from estimator.faults.fault import Fault
from estimator.faults.sentences import place_of
from estimator.faults.use import Use
from estimator.record import Array
from estimator.rig import Rig

LEAST = 0.05  # of its rise, that a loose thermometer does not show: sensors differ from each other by 2 to 3 %
SHARE = 0.25  # of both misfits' squares, down to which exchanging two plugs has to bring them
SHOWN_K = 0.3  # rms by which each of the two must be off before
FEW = 3  # channels that jump at once; more of them are the board's or the bus's


def of_readings(use: Use, read: AsRead) -> Iterator[Event]:
    """Events of single channels that were left out, or whose readings go on from another zero."""
    begun, rig = (use.name, read.recording.began_s), read.rig
    for jump in use.jumps:
        if len(jump.sizes) <= FEW:
            for channel, size in jump.sizes.items():
                yield _event(begun, jump.time_s, channel, rig, f"jumped by {size:+.2f}: its zero is another one", size)
    for one in use.suspects:
        for spell in one.spells:
            lost = share_lost(read, one.channel, spell.from_s) if spell.fault == Fault.DRIFTING else 0.0
            if lost:
                event = _event(begun, spell.from_s, one.channel, rig, loose_words(lost))
                yield replace(event, kind=LOOSE, share=-lost)
                continue
            doubt = "; if it is well, heat is missing there" if spell.fault == Fault.DRIFTING else ""
            yield _event(begun, spell.from_s, one.channel, rig, f"{spell.fault.said}: check that sensor{doubt}")


def _event(
    begun: tuple[str, float | None], since_s: float, channel: str, rig: Rig, what: str, size: float | None = None
) -> Event:  # fmt: skip
    run, began_s = begun
    what = f"{place_of(rig, rig.index(channel))} {what}"
    return Event(run, since_s, SPAN_S / 2, READING, began_s=began_s, channel=channel, offset=size, what=what)


def share_lost(read: AsRead, channel: str, since_s: float) -> float:
    """The share of its rise that a thermometer does not show from a time on; 0 where a steady drift explains more.

    Its misfit beside that of the thermometers next to it, which a model of another machine has too.
    """
    rig, at = read.rig, read.rig.index(channel)
    place = rig.channels[channel].at_mm
    if place is None:
        return 0.0
    since = read.time_s >= since_s
    off = (read.off[:, at] - _around(read, at, place))[since]
    rise, drift = (read.alone[:, at] - read.alone[0, at])[since], read.time_s[since] - since_s
    known = np.isfinite(off)
    if known.sum() < 2:
        return 0.0
    (share, left), (_, drifted) = (_fitted(off[known], column[known]) for column in (rise, drift))
    return -share if LEAST < -share <= 1.0 and left < drifted else 0.0


def loose_words(share: float) -> str:
    """What to know of one that does not show this share."""
    return f"shows {100 * share:.0f} % less of its rise, as a thermometer that has come loose does: fix it again"


def _around(read: AsRead, at: int, place: float) -> Array:
    """Mean misfit of the nearest thermometers to either side, (T,)."""
    others = {i: c.at_mm - place for i, c in enumerate(read.rig.channels.values()) if c.at_mm is not None and i != at}
    sides = [{i: abs(x) for i, x in others.items() if (x > 0) is side} for side in (True, False)]
    return np.asarray(np.mean([read.off[:, min(side, key=side.__getitem__)] for side in sides if side], axis=0))


def _fitted(off: Array, column: Array) -> tuple[float, float]:
    """How much of a column is in some values, and the square of what it leaves."""
    size = float(column @ off / max(column @ column, 1e-12))
    return size, float(((off - size * column) ** 2).sum())


def exchanged(read: AsRead) -> Iterator[Event]:
    """Pairs of thermometers of a recording."""
    rig, recording = read.rig, read.recording
    heard = np.flatnonzero(rig.is_thermometer & np.isfinite(read.off).any(axis=0))
    for one, other in _pairs(read.off, read.alone, heard):
        first, second = rig.names[one], rig.names[other]
        what = f"{first} and {second} show each other's temperature: exchange their plugs, or their signals in rig.toml"
        yield Event(
            recording.name, float(recording.time_s[0]), 0.0, EXCHANGED, began_s=recording.began_s, channel=first,
            name=second, what=what,
        )  # fmt: skip


def _pairs(off: Array, alone: Array, channels: Array) -> Iterator[tuple[int, int]]:
    """Of channels that fit each other's place far better than their own, the best pairs first, each channel once.

    None where another channel is as far off as exchanging may leave them: then it does not set the model right.
    """
    read = np.isfinite(off)
    own = np.where(read, off**2, 0.0).sum(axis=0) / np.maximum(read.sum(axis=0), 1)
    found = []
    for one, other in combinations(channels.tolist(), 2):
        apart = alone[:, one] - alone[:, other]
        there = np.nanmean((off[:, one] + apart) ** 2), np.nanmean((off[:, other] - apart) ** 2)
        both = there[0] < own[one] and there[1] < own[other] and min(own[one], own[other]) > SHOWN_K**2
        if both and sum(there) < SHARE * (own[one] + own[other]):
            found.append((sum(there) / (own[one] + own[other]), one, other))
    pairs: list[tuple[int, int]] = []
    for _, *pair in sorted(found):
        if not {*pair} & {*chain(*pairs)}:
            pairs.append((pair[0], pair[1]))
    most = max((own[channel] for channel in {*channels.tolist()} - {*chain(*pairs)}), default=0.0)
    yield from (pair for pair in pairs if most < SHARE * own[[*pair]].min())
