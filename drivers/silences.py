"""What a recording does not have for long: thermometers, inputs and the drive without a reading."""

from collections.abc import Iterator

import numpy as np

from drivers.frames import Array, Tally, few
from estimator.record import Recording
from estimator.rig import Rig, Signal

_LONG_S = 300.0
_STEPS = 20  # of the usual time between readings: a slow signal is not silent


def silences(recording: Recording, rig: Rig, tally: Tally) -> None:
    """Note for how long, from when on, and of what: those that are silent together in one sentence."""
    found: dict[tuple[int, int], list[str]] = {}
    for name, values in _signals(recording, rig):
        for span in _gaps(np.isfinite(values), recording.time_s):
            found.setdefault(span, []).append(name)
    for (first, last), names in sorted(found.items()):
        begin, end = recording.time_s[first], recording.time_s[last]
        tally.note(f"no reading of {few(names)} for {end - begin:.0f} s, from {begin:.0f} s on")


def _signals(recording: Recording, rig: Rig) -> Iterator[tuple[str, Array]]:
    """Those that are read all the time: not a displacement that is read in some states only."""
    for column, (name, channel) in enumerate(rig.channels.items()):
        if channel.is_thermometer and _always(channel):
            yield name, recording.channels[:, column]
    for name, rule in rig.inputs.items():
        if _always(rule) and name != "displacement_direct":
            yield name, recording.inputs[name]


def _always(rule: Signal) -> bool:
    return rule.fresh is None and rule.valid is None


def _gaps(known: Array, time_s: Array) -> Iterator[tuple[int, int]]:
    """First and last row of each long gap, where there is any reading; what is never there is told elsewhere."""
    at = np.flatnonzero(known)
    if not len(at):
        return
    usual = float(np.median(np.diff(time_s[at]))) if len(at) > 1 else 0.0
    rows = np.concatenate(([0], at, [len(known) - 1]))
    long = np.diff(time_s[rows]) > max(_LONG_S, _STEPS * usual)
    yield from zip(rows[:-1][long].tolist(), rows[1:][long].tolist())
