"""A wrong reading whose shape is drawn by the seed: which channel, a size, and a law that no list of effects has."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drivers.virtual_rig.dice import dice
from drivers.virtual_rig.machine.geometry import OMEGA_20
from estimator.record import Array, Recording
from estimator.rig import Rig

ALL = "all thermometers"
LENGTH = "displacement"
KINDS = {  # of each the laws that may be named for it
    "power": ("drive", "speed_root", "speed", "speed2"),
    "blast": ("early_stop", "slow_stop"),
    "soak": ("rest", "late_rest"),
    "clock": ("time",),
    "input": (),  # the input itself
}
INPUTS = {ALL: ("nut", "ambient"), LENGTH: ("ambient", "board", "free_bracket", "nut")}
OF_ONE = ("nut", "board")
OF_THERMOMETERS = ("power", "blast", "soak", "input")  # one that drifts with the clock is a fault
READ_WHILE_DRIVING = ("clock", "input")  # a run has one speed: what follows that is a part of its unknown zero
TURNS = 1.0  # rad/s, from which on the screw turns


@dataclass(frozen=True)
class DrawnReading:
    """One shape.

    kind     "power": |omega|^exponent;   "blast": fades after a stop;   "soak": comes after a stop;   "clock": with the
             hours;   "input": a power of how much an input has risen, its sign kept
    size     K or um where the law is 1: at 20 m/min, at once after a stop, after one hour, at the largest rise met
    """

    channel: str
    kind: str
    size: float
    exponent: float
    seconds: float
    input: str

    @property
    def follows(self) -> tuple[str, ...]:
        """What may be named for it."""
        return KINDS[self.kind] or (self.input,)

    def law(self, recording: Recording, largest_K: float) -> Array:
        """What the size is multiplied by, (K,); `largest_K`: rise of the input in any run."""
        turning, time_s = np.nan_to_num(recording.omega) > TURNS, recording.time_s
        if self.kind == "power":
            return np.asarray(np.nan_to_num(recording.omega) / OMEGA_20) ** self.exponent
        if self.kind == "clock":
            return np.asarray((time_s - time_s[0]) / 3600.0)
        if self.kind == "input":
            rise = _rise(recording, self.input) / largest_K
            return np.asarray(np.sign(rise) * np.abs(rise) ** (self.exponent / 1.5))
        since = time_s - np.maximum.accumulate(np.where(turning, time_s, -np.inf))
        fading = np.where(turning | ~np.isfinite(since), 0.0, np.exp(-since / self.seconds))
        rested = ~turning & np.isfinite(since)
        return np.asarray(fading if self.kind == "blast" else rested - fading)


def drawn_reading(seed: int, rig: Rig) -> DrawnReading:
    """The shape that a seed draws."""
    draw = dice(seed, "drawn_reading")
    channel = str(draw.choice([rig.thermometers[draw.integers(1, 14)], ALL, LENGTH], p=[0.45, 0.15, 0.4]))
    kinds = READ_WHILE_DRIVING if channel == LENGTH else OF_THERMOMETERS
    sizes = (2.0, 6.0) if channel == LENGTH else (0.15, 0.5)
    return DrawnReading(
        channel,
        kind=str(draw.choice(kinds)),
        size=float(draw.uniform(*sizes) * draw.choice([-1.0, 1.0])),
        exponent=float(draw.uniform(0.4, 2.6)),
        seconds=float(np.exp(draw.uniform(*np.log((150.0, 1500.0))))),
        input=str(draw.choice(INPUTS.get(channel, OF_ONE))),
    )


def misread(recordings: Sequence[Recording], one: DrawnReading, rig: Rig) -> list[Recording]:
    """The recordings as they would be read with it."""
    at = [rig.index(name) for name in (rig.thermometers if one.channel == ALL else [one.channel])]
    largest_K = max(float(np.nanmax(np.abs(_rise(each, one.input)))) for each in recordings)
    found = []
    for recording in recordings:
        channels = recording.channels.copy()
        channels[:, at] += one.size * one.law(recording, largest_K)[:, None]
        found.append(replace(recording, channels=channels))
    return found


def _rise(recording: Recording, name: str) -> Array:
    values = recording.inputs[name]
    return np.asarray(values - values[np.flatnonzero(np.isfinite(values))[0]])
