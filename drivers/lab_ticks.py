"""A lab CSV into ticks: each row closes one, or, where rows come faster than ticks, the timer does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drivers.budget import Budget
from drivers.clock import RigClock
from drivers.condense import Condenser, Readings
from drivers.frames import Tally
from drivers.labcsv import Table
from drivers.ticks import Ticks, split
from estimator.errors import InputError
from estimator.record import Recording
from estimator.rig import Rig, Signal

Array = NDArray[np.float64]


def read_lab(path: Path, rig: Rig, tally: Tally, budget: Budget) -> Recording:
    """Rows as ticks. Where rows are further apart than ticks, channels are not measured in between and inputs hold."""
    table = Table(path, rig, tally, budget)
    steps = np.diff(table.time)
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else rig.tick_s
    coarse = step >= rig.tick_s / 2
    clock = RigClock(max(rig.tick_s, step), tally, lambda row: f"line {int(table.line[row])}", budget)
    none = np.full(len(table.time), -1, np.int64)
    now = clock.run(table.time, np.zeros(len(none), bool), none)
    kept = np.flatnonzero(np.isfinite(now))
    now = now[kept]
    ends, date = split(now, np.full(len(now), coarse), Ticks(rig.tick_s, coarse), budget.ticks, tally)
    if not len(ends):
        raise InputError(f"{path}: {len(now)} rows over {now[-1]:.3g} s, less than one tick of {rig.tick_s:g} s")
    tally.skip("after the last whole tick", len(now) - ends[-1])
    row = np.repeat(np.arange(len(ends)), np.diff(ends, prepend=0))
    readings = {}
    for name, rule in [*rig.channels.items(), *rig.inputs.items()]:
        if name in table.columns:
            readings[name] = _readings(name, rule, table.columns[name][kept][: len(row)], row, now, tally)
    held = max(2, int(np.ceil(1.5 * step / rig.tick_s)))
    rows = Condenser(rig, tally, held).rows(readings, date)
    for column in rows.inputs.values():
        _hold(column, held if step > rig.tick_s else 0)
    return rows


def _readings(name: str, rule: Signal, cells: Array, row: NDArray[np.intp], now: Array, tally: Tally) -> Readings:
    value = rule.scale * cells + rule.offset
    with np.errstate(invalid="ignore"):
        outside = (value < rule.lo) | (value > rule.hi)
    tally.skip(f"out of range {name}", np.count_nonzero(outside))
    use = np.flatnonzero(np.isfinite(value) & ~outside)
    return Readings(use, row[use], now[use], value[use])


def _hold(column: Array, ticks: int) -> None:
    """Fill gaps with the last value, for at most so many ticks."""
    known = np.isfinite(column)
    latest = np.maximum.accumulate(np.where(known, np.arange(len(column)), -1))
    fill = ~known & (latest >= 0) & (np.arange(len(column)) - latest <= ticks)
    column[fill] = column[latest[fill]]
