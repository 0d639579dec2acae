"""A lab CSV into ticks: a line of names, a column of times, one column per channel or input, any step.

What was recognised by itself is said in one note: "';' between cells, ',' as decimal mark, names in line 5".
"""

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from drivers.budget import Budget
from drivers.decode.clock import RigClock, date_of
from drivers.decode.condense import Condenser, Readings
from drivers.decode.ticks import Ticks, split
from drivers.frames import Array, Index, Tally
from drivers.lab import counting, order, stamps
from drivers.lab.columns import Columns, column_names, find_columns, fresh_key, to_the_unit
from drivers.lab.doubts import admit, hot
from drivers.lab.numerals import NOTHING, decimal_mark, numbers, switched
from drivers.lab.sheet import Sheet, read_sheet
from estimator.errors import InputError
from estimator.record import Recording
from estimator.rig import Rig, Signal

_SAMPLE = 5000  # rows that tell the decimal mark
SWITCHED = ("1", "")  # units of what may be on or off; none: nobody has said one yet
_COARSEST_S = 90.0  # of a clock of hours and minutes


class Table:
    """The rows of a lab CSV: `time` (n,) s, `line` (n,) line numbers, `columns` (n,) per channel or input.

    units  of them, as far as the file says them;   local  whether times are of a day in no zone
    """

    def __init__(self, path: Path, rig: Rig, tally: Tally, budget: Budget) -> None:
        self.path, self.rig, self.tally = path, rig, tally
        signals = {**rig.channels, **rig.inputs}
        wanted = [rig.log.time_column, *column_names(rig).values()]
        sheet = read_sheet(path, rig.log.csv, wanted, tally, budget)
        found = find_columns(sheet, rig, tally)
        self.line = np.array(sheet.line, np.uint32)
        self.said = sheet.said
        self.units = {name: found.units.get(place) for name, place in found.of.items()}
        cells = {name: sheet.column(place) for name, place in found.of.items()}
        texts = found.stamps(sheet)
        self.mark = rig.log.csv.decimal or decimal_mark(_sample(cells, texts), sheet.separator, path)
        if self.mark == ",":
            self.said.append("',' as decimal mark")
        self.columns: dict[str, Array] = {}
        self.never: dict[str, str] = {}
        for name in cells:
            bare = name in signals and signals[name].unit in SWITCHED  # an "off" heater in W says no number
            values = switched(cells[name]) if bare else None
            self.said += [f"{name} on and off as 1 and 0"] if values is not None else []
            values = self._measured(cells[name], name) if values is None else values
            self.columns[name] = to_the_unit(values, sheet, found, name, signals[name]) if name in signals else values
        self.time, self.local = self._timed(texts, sheet, found)
        self._only_timed(texts)
        self._put_in_order()

    def _measured(self, cells: list[str], name: str) -> Array:
        values = numbers(cells, self.mark)
        wrong = np.isnan(values) & np.array([cell.lower() not in NOTHING for cell in cells], bool)
        self.tally.refuse("no number", name, np.count_nonzero(wrong))
        if wrong.any() and not np.isfinite(values).any():
            first = int(np.argmax(wrong))
            self.never[name] = f"{name} is '{cells[first][:40]}' in line {self.line[first]}, no number"
            if switched(cells) is not None:
                self.never[name] += '; an input that is on or off has unit = "1" in rig.toml'
            self.tally.note(self.never[name])
        return values

    def _timed(self, texts: list[str], sheet: Sheet, found: Columns) -> tuple[Array, bool]:
        """Seconds of each row, (n,), and whether they are times of a day in no zone."""
        rule = self.rig.log.csv
        count = numbers(texts, self.mark)
        if rule.decimal is None and np.isfinite(count).sum() * 2 <= len(count):
            count = numbers(texts, decimal_mark(_sample({}, texts), sheet.separator, self.path))
        if rule.time_format is None and np.isfinite(count).sum() * 2 > len(count):
            if len(found.time) > 1:
                raise InputError(f"{self.path}: dates and times are numbers; name one column as log.time_column")
            name = sheet.names[found.time[0]]
            of_file = found.units.get(found.time[0]) or counting.unit_in_name(name)
            place = f"{self.path}: '{name}'"
            time, said = counting.seconds(count, self.rig.tick_s, rule.time_unit, of_file, place)
            self.said += [said] if said else []
            return time, counting.zoneless(said)
        read = stamps.stamps(texts, rule.time_format, self.rig.tick_s, lambda k: f"{self.path}: line {self.line[k]}")
        self.said += [read.said] if read.said else []
        return read.time, read.local

    def _only_timed(self, texts: list[str]) -> None:
        good = np.isfinite(self.time) & (np.abs(self.time) < 4.2e9)
        self.tally.skip("time is no number", np.count_nonzero(~good))
        if not good.any():
            if not texts:
                raise InputError(f"{self.path}: 0 usable rows: nothing stands below the names")
            raise InputError(
                f"{self.path}: 0 usable rows: '{texts[0][:40]}' in line {self.line[0]} is no time; expected seconds, "
                "ISO times such as 2026-03-01 12:00:05, dates such as 01.03.2026 12:00:05, or time_format in csv of "
                "[log] in rig.toml"
            )
        self._take(np.flatnonzero(good))

    def _take(self, rows: Index) -> None:
        self.time, self.line = self.time[rows], self.line[rows]
        self.columns = {name: column[rows] for name, column in self.columns.items()}

    def _put_in_order(self) -> None:
        sort = self.rig.log.csv.sort
        if sort is not False and order.shuffled(self.time):
            self._sort()
        if sort is not False and order.newest_first(self.time):
            self._take(np.arange(len(self.time))[::-1])
            self.said.append("newest row first, turned round")
        if self.local:
            self.time, changes = order.summer_time(self.time)
            for row, to in changes:
                self.tally.note(f"the clock was put {to} an hour at line {self.line[row]}: no time passes there")
            shown = [self.columns[name] for name in self.rig.thermometers if name in self.columns]
            self.time, put = order.set_by_hand(self.time, np.array(shown).reshape(len(shown), len(self.time)))
            for row, by in put:
                what = f"the clock was put forward {by} at line {self.line[row]}, and no thermometer shows it"
                self.tally.note(f"{what}: no time passes there (times with a zone count as they are)")
        self.time, begun = order.going_on(self.time)
        self.said += [begun] if begun else []
        again = order.told_again(self.time, np.array(list(self.columns.values())))
        if len(again):
            self._take(np.setdiff1d(np.arange(len(self.time)), again))
            self.said.append(f"{len(again)} rows are there twice")
        if sort or (sort is None and order.out_of_order(self.time)):
            self._sort()
        self._apart()

    def _sort(self) -> None:
        if back := int((np.diff(self.time) < 0).sum()):
            self._take(np.argsort(self.time, kind="stable"))
            self.said.append(f"rows sorted by time: it went back {back} times")

    def _apart(self) -> None:
        """Rows of one time are one row, or so many between it and the next."""
        if len(self.time) > 1 and np.ptp(self.time) == 0:
            raise InputError(
                f"{self.path}: time stands still: all {len(self.time)} rows have the same; is it another column?"
            )
        if (shared := order.coarse(self.time)) > _COARSEST_S:
            raise InputError(
                f"{self.path}: times have a resolution of {shared:.6g} s, several rows share each: digits were lost; "
                "export them with all of them"
            )
        last, together = order.lasts(self.time, np.array(list(self.columns.values())))
        if len(last) < len(self.time):
            self.said.append(f"{len(self.time)} rows of {len(last)} times, taken together")
            self._take(last)
            self.columns = dict(zip(self.columns, together, strict=True))
        self.time, said = order.spread(self.time)
        self.said += [said] if said else []


def _sample(cells: dict[str, list[str]], texts: list[str]) -> list[str]:
    """Cells of some rows, all over the file."""
    step = max(len(texts) // _SAMPLE, 1)
    return [cell for column in [*cells.values(), texts] for cell in column[::step]]


def read_lab(path: Path, rig: Rig, tally: Tally, budget: Budget) -> Recording:
    """The rows of a lab CSV as ticks."""
    return ticks_of(Table(path, rig, tally, budget), budget)


def ticks_of(table: Table, budget: Budget) -> Recording:
    """Rows as ticks. Where rows are further apart than ticks, channels are not measured in between and inputs hold."""
    path, rig, tally = table.path, table.rig, table.tally
    steps = np.diff(table.time)
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else rig.tick_s
    coarse = step >= rig.tick_s / 2
    _tell(table, step, rig.tick_s)
    clock = RigClock(max(rig.tick_s, step), 1, tally, lambda row: f"line {int(table.line[row])}", budget, step)
    none = np.full(len(table.time), -1, np.int64)
    now = clock.run(table.time, np.zeros(len(none), bool), none)
    kept = np.flatnonzero(np.isfinite(now))
    now = now[kept]
    ticks = Ticks(rig.tick_s, coarse)
    closes = np.full(len(now), coarse)
    row, date = split(f"{path}: {len(now)} rows", now, closes, ticks, budget.ticks, tally, "row too soon (used)")
    readings = {}
    for name, rule in [*rig.channels.items(), *rig.inputs.items()]:
        if name in table.columns:
            cells = _fresh(table, name, rule)[kept][: len(row)]
            readings[name] = _readings(name, rule, cells, row, now, tally)
    admit(path, rig, table.columns, table.never, readings)
    hot(rig, readings, tally)
    held = max(2, int(np.ceil(1.5 * step / rig.tick_s)))
    began_s = date_of(table.time[kept], now)
    if began_s is not None and table.local:
        began_s = datetime.fromtimestamp(began_s, UTC).replace(tzinfo=None).timestamp()
    rows = replace(Condenser(rig, tally, held).whole(readings, date), began_s=began_s)
    for column in rows.inputs.values():
        _hold(column, held if step > rig.tick_s else 0)
    return rows


def _tell(table: Table, step: float, tick_s: float) -> None:
    """The one note of what was recognised by itself."""
    if not 0.5 < step / tick_s < 1.5:
        how = "none is measured in the ticks between" if step > tick_s else "the last of a tick counts"
        table.said.append(f"a row each {step:g} s, a tick each {tick_s:g} s: {how}")
    if table.said:
        table.tally.first(", ".join(table.said))


def _fresh(table: Table, name: str, rule: Signal) -> Array:
    """A column's numbers, (n,): NaN in rows in which what tells a new reading has not changed."""
    key, cells = fresh_key(name, rule), table.columns[name]
    if not key:
        return cells
    told = table.columns.get(key, np.full(len(cells), np.nan))
    known = np.flatnonzero(np.isfinite(told))
    new = known[np.diff(told[known], prepend=np.nan) != 0]
    return np.where(np.isin(np.arange(len(cells)), new), cells, np.nan)


def _readings(name: str, rule: Signal, cells: Array, row: Index, now: Array, tally: Tally) -> Readings:
    value = rule.scale * cells + rule.offset
    with np.errstate(invalid="ignore"):
        outside = (value < rule.lo) | (value > rule.hi)
    tally.refuse("out of range", name, np.count_nonzero(outside))
    use = np.flatnonzero(np.isfinite(value) & ~outside)
    return Readings(use, row[use], now[use], value[use])


def _hold(column: Array, ticks: int) -> None:
    """Fill gaps with the last value, for at most so many ticks."""
    known = np.isfinite(column)
    latest = np.maximum.accumulate(np.where(known, np.arange(len(column)), -1))
    fill = ~known & (latest >= 0) & (np.arange(len(column)) - latest <= ticks)
    column[fill] = column[latest[fill]]
