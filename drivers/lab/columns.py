"""Which column of a sheet is which channel or input, where its times are, and in which units."""

from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from drivers.frames import Array, Tally
from drivers.lab.names import nearest_name, unit_in
from drivers.lab.numerals import is_numeric, without_unit
from drivers.lab.sheet import Sheet, place_of
from drivers.lab.stamps import kind_of
from drivers.units import contradicts, unit_of
from estimator.errors import InputError
from estimator.rig import Rig, Signal

NAMELESS = "its first line holds numbers: write a line of names above it"
COLDEST_K = 150.0  # what is below is no machine in K
_SAMPLE = 40  # rows that show what a column holds
_MOST_HEAD = 5  # rows below the names that hold no measurement


@dataclass(frozen=True)
class Columns:
    """Places of columns: of each channel and input that has one; of the times, one, or a date's and a clock's.

    units  of columns, where the file says them
    """

    of: dict[str, int]
    time: tuple[int, ...]
    units: dict[int, str]

    def stamps(self, sheet: Sheet) -> list[str]:
        """The cells of the times, a date and its clock together, (n,): a date counts until the next is written."""
        cells = [[_text(row[k]) for k in self.time] for row in sheet.rows]
        for before, row in pairwise(cells if len(self.time) > 1 else []):
            row[0] = row[0] or before[0]
        return [" ".join(row).strip() for row in cells]


def column_names(rig: Rig) -> dict[str, str]:
    """The column of each channel and input, and under its `fresh_key` the one that tells a new reading of it."""
    rules = [*rig.channels.items(), *rig.inputs.items()]
    told = {key: rule.fresh for name, rule in rules if (key := fresh_key(name, rule)) and rule.fresh}
    return {name: rule.column or name for name, rule in rules} | told


def fresh_key(name: str, rule: Signal) -> str:
    """What the column that tells a new reading is known by; "" for none, or a signal on a bus."""
    return f"{name}: new" if rule.fresh and not rule.signals else ""


def find_columns(sheet: Sheet, rig: Rig, tally: Tally) -> Columns:
    """Find them by name, times by what they look like too; takes lines of units and the like from the rows."""
    names = column_names(rig)
    taken = {k for k, name in enumerate(sheet.names) if name in names.values() or name == rig.log.time_column}
    places = {name: place_of(sheet, column, taken) for name, column in names.items()}
    of = {name: place for name, place in places.items() if place is not None}
    if not any(name in of for name in rig.channels):
        free = [name for name in sheet.names if name not in names.values()]
        near = next(((found, names[name]) for name in rig.channels if (found := nearest_name(names[name], free))), None)
        hint = f"; is '{near[0]}' {near[1]}?" if near else _layout(sheet, {*names.values()})
        raise InputError(
            f"{sheet.path}: no column of any channel; expected {some(names.values())}, found {_found(sheet)}{hint}"
        )
    time = _times(sheet, rig.log.time_column, {*of.values()})
    units = {k: unit for k, name in enumerate(sheet.names) if (unit := unit_in(name))}
    units |= _out_of_cells(sheet, {*of.values(), *time})
    columns = Columns(of, time, units | _without_head(sheet, {*of.values()}, time))
    free = [name for k, name in enumerate(sheet.names) if k not in {*of.values(), *time} and name]
    if missing := [column for name, column in names.items() if name not in of]:
        hints = {column: nearest_name(column, free) for column in missing}
        told = (f"{column} (there is '{near}')" if near else column for column, near in hints.items())
        tally.note(f"no column {', '.join(told)}: not measured")
    for name in sorted({*free}):
        tally.skip(f"column not in the rig file {name[:40]}")
    return columns


def _layout(sheet: Sheet, names: set[str]) -> str:
    """What else a sheet without a known name is."""
    if sheet.nameless:
        return f"; {NAMELESS}"
    for k, name in enumerate(sheet.names):
        if names & {*sheet.column(k)}:
            return f"; a row for each reading, by '{name}': write a column for each instead"
    return ""


def _times(sheet: Sheet, name: str, taken: set[int]) -> tuple[int, ...]:
    same = [k for k, other in enumerate(sheet.names) if other == name]
    if len(same) > 1 and all(sheet.column(k) == sheet.column(same[0]) for k in same):
        sheet.said.append(f"the first of {len(same)} columns '{name}', which are alike")
        return (same[0],)
    place = place_of(sheet, name, taken)
    free = [k for k in range(len(sheet.names)) if k not in taken]
    kinds = {k: kind_in(sheet, k) for k in free}
    dates, clocks, whole = ([k for k in free if kinds[k] == kind] for kind in ("date", "clock", "stamp"))
    if place in clocks and len(dates) == 1:
        return dates[0], clocks[clocks.index(place)]
    if place in dates and len(clocks) == 1:
        return dates[dates.index(place)], clocks[0]
    if place is not None:
        return (place,)
    if len(whole) == 1 or (len(dates) == len(clocks) == 1 and not whole):
        found = (whole[0],) if whole else (dates[0], clocks[0])
        sheet.said.append("times in " + " and ".join(f"'{sheet.names[k]}'" for k in found))
        return found
    near = nearest_name(name, [sheet.names[k] for k in free])
    hint = f"; is it '{near}'? Name" if near else "; name"
    raise InputError(
        f"{sheet.path}: no time column '{name}' in the header ({_found(sheet)}){hint} it in rig.toml as log.time_column"
    )


def kind_in(sheet: Sheet, place: int) -> str:
    """What most of a column's first cells are: "date", "clock" or "stamp", "" for numbers and the like."""
    kinds = Counter(kind_of(cell) for row in sheet.rows[:_SAMPLE] if (cell := _text(row[place])))
    return max(kinds, key=kinds.__getitem__, default="")


def _text(cell: str) -> str:
    """A cell without brackets, and the mark by which spreadsheets keep it a text."""
    return cell.strip().strip("'[]")


def _out_of_cells(sheet: Sheet, places: Collection[int]) -> dict[int, str]:
    """Take units that stand behind the numbers of a column, such as "22.1 °C", from its cells; which they are."""
    units: dict[int, str] = {}
    for k in places:
        found = [tail for row in sheet.rows[:_SAMPLE] if (tail := without_unit(row[k].strip())[1])]
        tail, count = Counter(found).most_common(1)[0] if found else ("", 0)
        if 2 * count > len(sheet.rows[:_SAMPLE]) and (unit := unit_of(tail)):
            units[k] = unit
            for row in sheet.rows:
                row[k] = row[k].strip().removesuffix(tail)
    return units


def _without_head(sheet: Sheet, measured: set[int], time: tuple[int, ...]) -> dict[int, str]:
    """Take the rows before the first measurement from the sheet; the units that one of them tells."""
    units: dict[int, str] = {}
    for _ in range(_MOST_HEAD):
        if (
            not sheet.rows
            or any(is_numeric(sheet.rows[0][k]) for k in {*measured, *time})
            or _is_time(sheet.rows[0], time)
        ):
            break
        row, line = sheet.rows.pop(0), sheet.line.pop(0)
        if told := {k: unit for k, cell in enumerate(row) if (unit := unit_of(cell))}:
            units |= told
            sheet.said.append(f"units in line {line}")
    return units


def _is_time(row: list[str], time: tuple[int, ...]) -> bool:
    return bool(kind_of(" ".join(row[k].strip() for k in time)))


def to_the_unit(values: Array, sheet: Sheet, columns: Columns, name: str, rule: Signal) -> Array:
    """A column's numbers, (n,), in the unit of rig.toml: K as degC; another that the file says is an InputError.

    A scale or an offset in rig.toml says that its writer knows the file's unit. "TC1 (K)" may be a type of
    thermocouple.
    """
    said = columns.units.get(columns.of[name])
    if said is None or (rule.scale, rule.offset) != (1.0, 0.0) or not contradicts(said, rule.unit):
        return values
    if (said, rule.unit) == ("K", "degC"):
        known = values[np.isfinite(values)]
        if len(known) and np.median(known) < COLDEST_K:
            return values
        sheet.said.append(f"{name} in K")
        return values - 273.15
    raise InputError(
        f"{sheet.path}: column '{sheet.names[columns.of[name]]}' is in {said}, rig.toml has {name} in {rule.unit}: "
        "convert it there with scale and offset"
    )


def _found(sheet: Sheet) -> str:
    return some([name for name in sheet.names if name]) or "empty"


def some(names: Any) -> str:
    """The first of these names, in words."""
    names = list(names)
    return (", ".join(names[:6]) + (" ..." if len(names) > 6 else ""))[:200]
