"""Rows in the order of their times, and times apart where rows share one.

Loggers write the newest row first, parts the wrong way round, and several rows under one stamp. A clock that was set
back is no matter of order: its rows stay where they are, and the rig's clock deals with it.
"""

import numpy as np

from drivers.frames import Array, Index
from drivers.lab.stamps import DAY_S, HOUR_S

_PART = 3  # rows that are alike to the last digit by no accident
_MIXED = 0.25  # of all rows go back, and as many on: no clock was set so often
_ROOM = 0.5  # of a usual step: rows closer than this share a time
_OF_ONE_CLOCK = 0.6  # of a usual step: rows out of order are as far apart, those of two clocks are closer somewhere
_PERIODS_S = (DAY_S, DAY_S / 2, HOUR_S, 7 * DAY_S, 2**32 * 1e-6, 2**31 * 1e-6, 2**32 * 1e-3, 2**31 * 1e-3, 2.0**16)
_MOST_ZONES = 14  # hours: no zone is further ahead
_ABOUT = 50  # rows on either side that show by how much a reading changes
_YEAR_S = 3.15e7  # parts of one run are not years apart: a clock that lost its date


def newest_first(time: Array) -> bool:
    """Whether the rows are in the opposite order."""
    steps = np.diff(time)
    return bool((steps < 0).sum() > (steps > 0).sum())


def shuffled(time: Array) -> bool:
    """Whether the rows stand in the order of something else, as a spreadsheet sorts them, and can be sorted by time."""
    steps, apart = np.diff(time), np.diff(np.sort(time))
    mixed = min((steps < 0).sum(), (steps > 0).sum()) > _MIXED * len(steps)
    return bool(mixed and _runs_on(time) and (apart >= _OF_ONE_CLOCK * np.median(apart)).all())


def out_of_order(time: Array) -> bool:
    """Whether times are out of order and can be sorted: the clock was not set back."""
    return bool((np.diff(time) < 0).any() and _runs_on(time) and (_apart(time) or _blocks(time)))


def _runs_on(time: Array) -> bool:
    return bool(np.diff(np.sort(time)).max() < _YEAR_S)


def told_again(time: Array, columns: Array) -> Index:
    """Rows that are there already, with all their cells (m, n), where times go back: parts of a log that overlap."""
    if not (np.diff(time) < 0).any():
        return np.empty(0, np.intp)
    _, first = np.unique(np.vstack([time, np.nan_to_num(columns, nan=np.inf)]), axis=1, return_index=True)
    again = np.setdiff1d(np.arange(len(time)), first)
    return again if len(again) >= _PART else again[:0]


def _apart(time: Array) -> bool:
    """Whether all rows, once sorted, are as far apart as rows usually are."""
    steps, usual = np.diff(np.sort(time)), np.diff(time)
    return bool((steps >= _OF_ONE_CLOCK * np.median(usual[usual > 0])).all()) if (usual > 0).any() else False


def _blocks(time: Array) -> bool:
    """Whether the rising parts follow each other without overlap, once they are in order."""
    starts = np.flatnonzero(np.diff(time, prepend=np.inf) < 0)
    ends = np.append(starts[1:], len(time)) - 1
    by_start = np.argsort(time[starts], kind="stable")
    return bool((time[starts[by_start]][1:] > time[ends[by_start]][:-1]).all())


def summer_time(time: Array) -> tuple[Array, list[tuple[int, str]]]:
    """Local times without the hours that a change of the clock takes or gives, and at which rows they were.

    Local time leaves out an hour when summer begins, and has one twice when it ends.
    """
    steps = np.diff(time)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    most = 1.5 * usual
    before, after = -time[:-1] % HOUR_S, time[1:] % HOUR_S  # from the full hour
    change = (before <= most) & (after <= most) & (most < HOUR_S / 2)
    hours = np.where(change, np.rint((steps - before - after) / HOUR_S), 0.0)
    hours[np.abs(hours) != 1] = 0.0
    time = time - HOUR_S * np.concatenate(([0.0], np.cumsum(hours)))[: len(time)]
    return time, [(int(row) + 1, "forward" if hours[row] > 0 else "back") for row in np.flatnonzero(hours)]


def set_by_hand(time: Array, thermometers: Array) -> tuple[Array, list[tuple[int, str]]]:
    """Local times without whole hours by which a clock was put forward, its zone say, and at which rows it was by what.

    Each is a step that is usual but for these hours, over which no thermometer (m, n) changes by more than it does from
    row to row about there. One that has stood still all along tells nothing.
    """
    steps = np.diff(time)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    hours = np.rint((steps - usual) / HOUR_S)
    whole = (hours >= 1) & (hours <= _MOST_ZONES) & (np.abs(steps - usual - hours * HOUR_S) < _ROOM * usual)
    change = np.abs(np.diff(thermometers, axis=1))
    put = np.array([k for k in np.flatnonzero(whole) if usual < HOUR_S and _unseen(change, int(k))], np.intp)
    ahead = np.zeros(len(time))
    ahead[put + 1] = hours[put]
    return time - HOUR_S * np.cumsum(ahead), [(int(row) + 1, f"{hours[row]:.0f} h") for row in put]


def _unseen(change: Array, row: int) -> bool:
    """Whether no column changes more at this row than at those about it, and some change there at all."""
    about = np.delete(change[:, max(row - _ABOUT, 0) : row + _ABOUT + 1], min(row, _ABOUT), axis=1)
    most = np.fmax.reduce(about, axis=1, initial=0.0)
    here = change[:, row]
    return bool((np.isfinite(here) & (most > 0)).any() and not (here > most).any())


def going_on(time: Array) -> tuple[Array, str]:
    """Times that begin again after a day, half a day, an hour, or where a counter is full, going on, (n,) s; in words.

    Each fall that is a whole period less a usual step.
    """
    steps = np.diff(time)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    for period in _PERIODS_S:
        again = (steps < -usual) & (np.abs(steps + period - usual) < _OF_ONE_CLOCK * usual)
        if again.any():
            time = time + period * np.concatenate(([0], np.cumsum(again)))
            return time, f"times begin again after {period:.10g} s: going on"
    return time, ""


def shared(time: Array) -> tuple[Index, Index]:
    """First row of each run of equal times, (g,), and how many rows it has, (g,)."""
    first = np.flatnonzero(np.diff(time, prepend=np.nan) != 0)
    return first, np.diff(np.append(first, len(time)))


def coarse(time: Array) -> float:
    """How far times are apart that are most often shared by several rows, s; 0 where they are not."""
    first, count = shared(time)
    return float(np.median(np.abs(np.diff(time[first])))) if len(first) > 1 and np.median(count) > 1 else 0.0


def lasts(time: Array, columns: Array) -> tuple[Index, Array]:
    """Rows that are one: of equal times, alike, or each with other cells filled. Their last row (g,) and cells (m, g).

    columns  (m, n), NaN where a cell is empty
    """
    first, count = shared(time)
    last = first + count - 1
    filled = np.isfinite(columns)
    here = np.maximum.accumulate(np.where(filled, np.arange(len(time)), -1), axis=1)[:, last]
    together = np.where(here >= first, np.take_along_axis(columns, np.maximum(here, 0), axis=1), np.nan)
    same = np.repeat(together, count, axis=1)
    one = ((columns == same) | ~filled).all(axis=0)
    if count.max(initial=1) > 1 and np.logical_and.reduceat(one, first)[count > 1].mean() > 0.5:
        return last, together
    return np.arange(len(time)), columns


def spread(time: Array) -> tuple[Array, str]:
    """Times of rows of which several have the same, evenly over the time until the next, and what was done, in words.

    Where that leaves less than half a usual step for each, the clock stood still: each row takes a usual step.
    """
    first, count = shared(time)
    if len(first) < 2 or count.max() < 2:
        return time, ""
    gap = np.diff(time[first])
    rows = float(np.median(count))
    step = float(np.median(gap[gap > 0])) / rows if (gap > 0).any() else 0.0
    gap = np.where((gap := np.append(gap, -1.0)) > 0, gap, count * step)
    each = np.where(gap > 1.5 * count * step, step, gap / count)
    still = (count > 1) & (each < _ROOM * step)
    each[still] = step
    begin = time[first] + np.concatenate(([0.0], np.cumsum(np.where(still, count * step - gap, 0.0))[:-1]))
    if count[0] < rows and not still[0]:  # it began in the middle of its stamp
        begin[0], each[0] = begin[0] + max(gap[0] - count[0] * step, 0.0), step
    within = np.arange(len(time)) - np.repeat(first, count)
    said = (
        [f"up to {count.max()} rows share a time, {rows * step:g} s from the next: spread evenly"] if rows > 1 else []
    )
    if rows <= 1 and (several := (count > 1) & ~still).any():
        said.append(f"{int(count[several].sum())} rows share times: spread until the next")
    if still.any():
        said.append(f"time stands still over {int(count[still].sum())} rows: each counts as {step:g} s")
    return np.repeat(begin, count) + within * np.repeat(each, count), "; ".join(said)
