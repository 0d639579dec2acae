"""Stretches of time in which what is missing may be taken as constant: one phase each, a block (`Trial.block_s`) at
most; longer ones of a recording of many hours, for the work grows with the cube of their number.
"""

from dataclasses import dataclass

import numpy as np

from estimator.inputs.phase import phase_of
from estimator.record import Array, Recording

MOST = 24  # such stretches that a recording is cut into were it one phase: one of four hours
# its readings are averaged up to each of these shares of a block, and after the last
BINS = {"drive": (0.1, 0.3), "early_stop": (0.1, 0.3), "late_stop": (0.5,)}
PARTS = 3
ALIKE = 2.0  # blocks: what is missing stays alike for so long


@dataclass(frozen=True)
class Blocks:
    """Blocks of a recording of T ticks, and bins: the parts of a block whose readings are averaged.

    of_tick  (T,) block of each tick;  bin_of_tick  (T,)
    phase    (B,) of str;  at_s (B,) mean time;  seconds (B,) that belong to it
    ticks    (bins,) in each bin;  bin_at_s  (bins,) mean time
    alike_s  how long what is missing stays alike
    """

    of_tick: Array
    bin_of_tick: Array
    phase: Array
    at_s: Array
    seconds: Array
    ticks: Array
    bin_at_s: Array
    alike_s: float

    def __len__(self) -> int:
        return len(self.phase)

    def mean(self, column: Array) -> Array:
        """Mean of a column (T,) over each block, (B,), of what is finite; NaN where nothing is."""
        return _mean(column, self.of_tick, len(self))

    def bin_mean(self, column: Array) -> Array:
        """Likewise over each bin, (bins,)."""
        return _mean(column, self.bin_of_tick, len(self.bin_at_s))

    def alike(self) -> Array:
        """Correlation (B, B) of what is smooth in time: exp(-distance / alike_s)."""
        return np.asarray(np.exp(-np.abs(self.at_s[:, None] - self.at_s) / self.alike_s))


def blocks(recording: Recording, tick_s: float, block_s: float) -> Blocks:
    """Cut a recording: each tick joins the open block of its phase, unless that began `block_s` before.

    So a long phase is cut, while short drives and stops in turn share two blocks.
    """
    time_s, phases = recording.time_s, phase_of(recording)
    longest_s = max(block_s, float(time_s[-1] - time_s[0]) / MOST)
    opened: dict[str, int] = {}
    began: list[float] = []
    of_tick, since = np.empty(len(time_s), dtype=int), np.empty(len(time_s))
    for k, (time, phase) in enumerate(zip(time_s.tolist(), phases.tolist(), strict=True)):
        if phase not in opened or time - began[opened[phase]] >= longest_s:
            opened[phase] = len(began)
            began.append(time)
        of_tick[k] = opened[phase]
        since[k] = time - began[of_tick[k]]
    part = of_tick * PARTS
    for phase, ends in BINS.items():
        part += np.where(phases == phase, np.searchsorted(ends, since / block_s, "right"), 0)
    _, bin_of_tick = np.unique(part, return_inverse=True)
    count, ticks = np.bincount(of_tick), np.bincount(bin_of_tick)
    return Blocks(
        of_tick, bin_of_tick, phases[np.unique(of_tick, return_index=True)[1]],
        np.bincount(of_tick, time_s) / count, count * tick_s,
        ticks, np.bincount(bin_of_tick, time_s) / ticks, ALIKE * block_s,
    )  # fmt: skip


def _mean(column: Array, group: Array, groups: int) -> Array:
    known = np.isfinite(column)
    count = np.bincount(group, known, groups)
    total = np.bincount(group, np.where(known, column, 0.0), groups)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
