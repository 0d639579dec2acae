"""Temperature inputs that cannot be: refused, so that what was known before them is held.

A thermometer of the air, the base, the board or the probe has no model to be compared with, but it is slow: what jumps
from one tick to the next, further than it scatters, is not its temperature, for as long as it stays away. One that is
far from the screw at the start has nothing before it, and is not taken. Inputs of other names may be quick.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from estimator.cover import AT_ONCE
from estimator.faults.fault import Fault
from estimator.faults.standstill import Standstill
from estimator.faults.suspects import STUCK
from estimator.inputs.start import Start
from estimator.inputs.untold import UNTOLD_S
from estimator.record import POWER_ON_C, Array, Recording
from estimator.rig import Rig

SLOW = ("ambient", "base", "board", "probe", "bar", "nut", "anchor_bracket", "free_bracket")
FAR_K = 25.0  # from the screw at the start: no place around a machine that has just been switched on
ASLEEP_K = 5.0  # exactly what a thermometer says after power-on, and so far from the screw: it says nothing yet
LEAST_K, LEAST_K_S = 0.5, 0.1  # of a jump, and more where ticks are long
SCATTERS = 6.5
TICKS = 8.0  # over which level and scatter are learnt


class Level:
    """Where one slow temperature is, by the readings that were taken; numbers one by one, for arrays of a tick cost
    twenty times as much. After so many ticks without a reading, `forgets`, it may be anywhere."""

    def __init__(self, least_K: float, forgets: float) -> None:
        self._least, self._value, self._last, self._variance = least_K, math.nan, math.nan, 0.0
        self._forgets, self._missed = forgets, 0

    def jumped(self, readings: Sequence[float], at_first: Sequence[bool]) -> list[bool]:
        """Which of the next readings, NaN: none, are refused, and would be `at_first`; the others are learnt."""
        value, last, variance, missed, least = self._value, self._last, self._variance, self._missed, self._least
        refused = [False] * len(readings)
        for k, now in enumerate(readings):
            if not -math.inf < now < math.inf:
                missed += 1
                continue
            if missed > self._forgets or value != value:
                refused[k] = at_first[k]
                value, last = (value, last) if at_first[k] else (now, now)
            else:
                change = now - last
                if not -least <= now - value <= least:  # next to none is: the rest costs more than all else
                    limit = max(SCATTERS * math.sqrt(variance), least)
                    refused[k] = abs(now - value) > limit and abs(change) > 0.7 * limit
                if not refused[k]:
                    variance += (change * change / 2.0 - variance) / TICKS
                    value += (now - value) / TICKS
                    last = now
            missed = 0
        self._value, self._last, self._variance, self._missed = value, last, variance, missed
        return refused


class InputGate:
    """What is known of each input of a rig.

    fault  (p,) in the order of Rig.inputs, a Fault each, as of the last tick; of slow temperatures only
    """

    def __init__(self, rig: Rig, start: Start) -> None:
        self._names, self._start = list(rig.inputs), start
        self._slow, p = np.array([slow(name, rig) for name in self._names], dtype=bool), len(self._names)
        least_K, forgets = LEAST_K + LEAST_K_S * rig.tick_s, UNTOLD_S / rig.tick_s
        self._levels = [Level(least_K, forgets) for _ in range(self._slow.sum())]
        self.fault = np.zeros(p, dtype=np.int8)
        self._standstill = Standstill(np.ones(p, dtype=bool))

    def passed(self, chunk: Recording) -> tuple[Array, Array]:
        """The inputs of the next ticks (K, p), NaN where they are refused, and the faults (K, p) that they have."""
        if len(chunk) <= AT_ONCE:
            return self._passed(chunk)
        parts = [self._passed(chunk.rows(slice(k, k + AT_ONCE))) for k in range(0, len(chunk), AT_ONCE)]
        passed, fault = map(np.concatenate, zip(*parts, strict=True))
        return passed, fault

    def _passed(self, chunk: Recording) -> tuple[Array, Array]:
        given = np.array([chunk.inputs[name] for name in self._names]).reshape(-1, len(chunk)).T
        readings = np.where(self._slow, given, np.nan)
        repeats = self._standstill.compare(readings)
        self._standstill.learn(repeats, len(given))
        some, jumped = given[:, self._slow], np.zeros(given.shape, dtype=bool)
        columns = zip(self._levels, some.T.tolist(), far(some, self._start).T.tolist(), strict=True)
        jumped[:, self._slow] = np.array([level.jumped(*column) for level, *column in columns]).reshape(some.T.shape).T
        stuck = repeats.count >= STUCK
        fault = np.where(jumped, Fault.JUMPED, np.where(stuck, Fault.STUCK, Fault.NONE)).astype(np.int8)
        self.fault = fault[-1] if len(fault) else self.fault
        return np.where(jumped, np.nan, given), fault


def far(value: Array | float, start: Start) -> Array:
    """Whether temperatures at the start are none: too far from the screw's, or not converted yet."""
    off = np.abs(value - start.level_C)
    return np.asarray((off > FAR_K) | (np.isin(value, POWER_ON_C) & (off > ASLEEP_K)))


def slow(name: str, rig: Rig) -> bool:
    """Whether an input is a temperature that cannot jump."""
    return name in SLOW and rig.inputs[name].unit == "degC"


def believable(inputs: Mapping[str, float], rig: Rig, start: Start) -> dict[str, float]:
    """The inputs of the first sample, NaN where they are too far from the screw's temperature."""
    return {n: float("nan") if slow(n, rig) and far(value, start) else value for n, value in inputs.items()}
