"""When nothing told what was done to the machine: a drive that is not heard of may have stood or turned all the time.

What the filter does then is in `network.unknown`. The model alone knows nothing any more from there on, so that what is
judged by it takes the stretches of a recording one by one, each with a start of its own.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from estimator.record import Array, Recording
from estimator.rig import Rig

UNTOLD_S = 60.0  # for which what was known last still stands: a drive of a minute is 5 um
LEAST_S = 300.0  # a shorter stretch is no recording


def told(recording: Recording, rig: Rig) -> Array:
    """Whether anything told in a tick what was done, (K,): the drive, on a rig without one any channel or input."""
    if "speed" in rig.inputs:
        return np.isfinite(recording.omega)
    columns = [*recording.channels.T, *recording.inputs.values()]
    return np.asarray(np.isfinite(columns).any(axis=0))


class Untold:
    """Whether the machine may have been driven unseen: without a drive's news at once, on a rig without a drive, whose
    inputs may come in turns, when nothing at all has come for long."""

    def __init__(self, rig: Rig) -> None:
        self._rig, self._ticks = rig, 0
        self._most = 0.0 if "speed" in rig.inputs else UNTOLD_S

    def unseen(self, chunk: Recording) -> Array:
        """Of each of the next ticks, (K,)."""
        k = np.arange(1, len(chunk) + 1)
        last = np.maximum.accumulate(np.where(told(chunk, self._rig), k, -self._ticks))
        self._ticks = int(k[-1] - last[-1]) if len(k) else self._ticks
        return np.asarray((k - last) * self._rig.tick_s > self._most)


def stretches(recording: Recording, rig: Rig) -> list[Recording]:
    """The recording, parted where it was not told for long; without stretches too short, unless that is all."""
    longs = [part for part in _parts(recording, rig) if len(part) * rig.tick_s >= LEAST_S]
    return longs or [recording]


def gaps_s(recording: Recording, rig: Rig) -> list[tuple[float, float]]:
    """From when to when it was not told for long, s."""
    at, ends = _gaps(recording, rig)
    return [(float(recording.time_s[at[end - 1]]), float(recording.time_s[at[end]])) for end in ends]


def _gaps(recording: Recording, rig: Rig) -> tuple[Array, Array]:
    """Ticks in which it was told; which of them come after a long gap."""
    at = np.flatnonzero(told(recording, rig))
    return at, np.flatnonzero(np.diff(at) * rig.tick_s > UNTOLD_S) + 1


def _parts(recording: Recording, rig: Rig) -> Iterator[Recording]:
    at, ends = _gaps(recording, rig)
    for ticks in np.split(at, ends) if len(ends) else ():
        part = recording.rows(slice(int(ticks[0]), int(ticks[-1]) + 1))
        name = f"{recording.name} from {part.time_s[0]:.0f} s"
        yield replace(part, name=name, part_of=recording.fingerprint)
