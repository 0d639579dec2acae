"""A plain lab CSV: a header row, a time column in seconds or ISO times, one column per channel or input, any step."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from contextlib import suppress
from datetime import UTC, datetime
from itertools import islice
from pathlib import Path

import numpy as np

from drivers.budget import Budget
from drivers.decode.clock import RigClock
from drivers.decode.condense import Condenser, Readings
from drivers.decode.ticks import Ticks, split
from drivers.frames import Array, Index, Tally
from estimator.errors import InputError
from estimator.record import Recording
from estimator.rig import Rig, Signal

HOUR_S = 3600.0


class Table:
    """The rows of a lab CSV: `time` (n,) s, `line` (n,) line numbers, `columns` (n,) per channel or input."""

    def __init__(self, path: Path, rig: Rig, tally: Tally, budget: Budget) -> None:
        self.path = path
        self.tally = tally
        with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
            rows = csv.reader(_whole_lines(file, tally, budget))
            try:
                header = [cell.strip() for cell in next(rows, [])]
                self.columns: dict[str, Array] = {}
                where = self._where(header, rig)
                cells = self._cells(rows, len(header), budget)
            except csv.Error as error:
                raise InputError(f"{path}: no CSV: {error}; expected commas and a header row") from None
        self.line = np.array([line for line, _ in cells], np.uint32)
        columns = list(zip(*(row for _, row in cells), strict=True)) or [()] * len(header)
        stamps = columns[header.index(rig.log.time_column)]
        self.time = _numbers(stamps, _seconds)
        for name, index in where.items():
            self.columns[name] = self._measured(columns[index], name)
        self._only_timed()
        if any(map(_is_local, stamps[:10])):
            self._without_summer_time()

    def _where(self, header: list[str], rig: Rig) -> dict[str, int]:
        """Column number of each channel and input that has one."""
        if rig.log.time_column not in header:
            names = ", ".join(header[:6]) + (" ..." if len(header) > 6 else "")
            raise InputError(
                f"{self.path}: no time column '{rig.log.time_column}' in the header ({names[:200] or 'empty'}); "
                "name it in rig.toml as log.time_column"
            )
        names = {name: rule.column or name for name, rule in [*rig.channels.items(), *rig.inputs.items()]}
        where = {name: header.index(column) for name, column in names.items() if column in header}
        if missing := [column for name, column in names.items() if name not in where]:
            self.tally.note(f"no column {', '.join(missing)}: not measured")
        if not any(name in where for name in rig.channels):
            raise InputError(f"{self.path}: no column of any channel; expected {', '.join(list(names.values())[:8])}")
        for column in sorted({*header} - {*names.values(), rig.log.time_column, ""}):
            self.tally.skip(f"column not in the rig file {column[:40]}")
        return where

    def _cells(self, rows: Iterator[list[str]], width: int, budget: Budget) -> list[tuple[int, list[str]]]:
        cells = []
        for row in islice(rows, budget.frames // max(width, 1)):
            if len(row) == width:
                cells.append((rows.line_num, row))  # type: ignore[attr-defined]
            elif row:
                self.tally.skip("row with a wrong number of cells")
        return cells

    def _measured(self, cells: tuple[str, ...], name: str) -> Array:
        values = _numbers(cells, _number)
        wrong = np.isnan(values) & np.array([cell.strip().lower() not in ("", "nan") for cell in cells], bool)
        self.tally.skip(f"no number {name}", np.count_nonzero(wrong))
        return values

    def _only_timed(self) -> None:
        good = np.isfinite(self.time) & (np.abs(self.time) < 4.2e9)
        self.tally.skip("time is no number", np.count_nonzero(~good))
        self.time, self.line = self.time[good], self.line[good]
        self.columns = {name: column[good] for name, column in self.columns.items()}
        if not len(self.time):
            raise InputError(
                f"{self.path}: 0 usable rows; expected a header row, then seconds or ISO times and numbers"
            )

    def _without_summer_time(self) -> None:
        """Local time leaves out an hour when summer begins, and has one twice when it ends."""
        steps = np.diff(self.time)
        most = 1.5 * np.median(steps[steps > 0]) if (steps > 0).any() else 0.0
        before, after = -self.time[:-1] % HOUR_S, self.time[1:] % HOUR_S  # from the full hour
        change = (before <= most) & (after <= most) & (most < HOUR_S / 2)
        hours = np.where(change, np.rint((steps - before - after) / HOUR_S), 0.0)
        hours[np.abs(hours) != 1] = 0.0
        for row in np.flatnonzero(hours):
            to = "forward" if hours[row] > 0 else "back"
            self.tally.note(f"the clock was put {to} an hour at line {self.line[row + 1]}: no time passes there")
        self.time[1:] -= HOUR_S * np.cumsum(hours)


def _whole_lines(file: Iterator[str], tally: Tally, budget: Budget) -> Iterator[str]:
    """Lines with their end: the last one may be cut short."""
    size = number = 0
    while line := file.readline(1 << 16):  # type: ignore[attr-defined]
        number += 1
        size += len(line)
        if not line.endswith(("\n", "\r")):
            tally.skip("torn line")
            tally.note(f"torn at line {number}: it has no line end; read up to there")
            return
        if size > budget.size:
            tally.note(f"stopped at line {number}: {budget.spent(0, size, late=False)}")
            return
        yield line.replace("\0", "?")


def _numbers(cells: tuple[str, ...], number: Callable[[str], float]) -> Array:
    try:
        return np.array(cells, dtype=float)
    except ValueError:
        return np.array([number(cell) for cell in cells])


def _seconds(cell: str) -> float:
    """Seconds from a number or an ISO time; NaN if it is neither. Local time counts the same on every machine."""
    try:
        return float(cell)
    except ValueError:
        with suppress(ValueError, OverflowError, OSError):
            time = datetime.fromisoformat(cell.strip())
            return (time if time.tzinfo else time.replace(tzinfo=UTC)).timestamp()
    return np.nan


def _is_local(cell: str) -> bool:
    """Whether it is a time of day that names no zone."""
    with suppress(ValueError):
        return ":" in cell and datetime.fromisoformat(cell.strip()).tzinfo is None
    return False


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return np.nan


def read_lab(path: Path, rig: Rig, tally: Tally, budget: Budget) -> Recording:
    """Rows as ticks. Where rows are further apart than ticks, channels are not measured in between and inputs hold."""
    table = Table(path, rig, tally, budget)
    steps = np.diff(table.time)
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else rig.tick_s
    coarse = step >= rig.tick_s / 2
    clock = RigClock(max(rig.tick_s, step), 1, tally, lambda row: f"line {int(table.line[row])}", budget)
    none = np.full(len(table.time), -1, np.int64)
    now = clock.run(table.time, np.zeros(len(none), bool), none)
    kept = np.flatnonzero(np.isfinite(now))
    now = now[kept]
    ticks = Ticks(rig.tick_s, coarse)
    row, date = split(f"{path}: {len(now)} rows", now, np.full(len(now), coarse), ticks, budget.ticks, tally)
    readings = {}
    for name, rule in [*rig.channels.items(), *rig.inputs.items()]:
        if name in table.columns:
            readings[name] = _readings(name, rule, table.columns[name][kept][: len(row)], row, now, tally)
    held = max(2, int(np.ceil(1.5 * step / rig.tick_s)))
    rows = Condenser(rig, tally, held).rows(readings, date)
    for column in rows.inputs.values():
        _hold(column, held if step > rig.tick_s else 0)
    return rows


def _readings(name: str, rule: Signal, cells: Array, row: Index, now: Array, tally: Tally) -> Readings:
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
