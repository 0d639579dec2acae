"""Two plugs exchanged: each of two thermometers shows what the other's place would by the model alone.

A model whose heat is in the wrong place makes two thermometers at either end of it look so too, but not only these.
"""

from collections.abc import Iterator
from itertools import chain, combinations

import numpy as np

from estimator.events.event import EXCHANGED, Event
from estimator.events.signature import AsRead
from estimator.record import Array

SHARE = 0.25  # of both misfits' squares, down to which exchanging the two has to bring them
SHOWN_K = 0.3  # rms by which each of the two must be off before


def exchanged(read: AsRead) -> Iterator[Event]:
    """Pairs of thermometers of a recording."""
    rig, recording = read.rig, read.recording
    for one, other in _pairs(read.off, read.alone, np.flatnonzero(rig.is_thermometer)):
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
