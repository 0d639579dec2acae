"""A lab CSV, or an MF4 of signals, of a rig that nobody has described yet: its times, and every column of numbers."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ballscrew.new_rig.seen import Seen
from ballscrew.new_rig.words import measure, tokens, unit_in_tail
from drivers.budget import Budget
from drivers.frames import Array, Tally
from drivers.lab import counting
from drivers.lab.columns import NAMELESS, kind_in
from drivers.lab.lab import Table
from drivers.lab.numerals import decimal_mark, numbers
from drivers.lab.sheet import Sheet, read_sheet
from drivers.lab.signals import every_signal, is_decoded
from drivers.logs.logs import is_lab_csv
from drivers.units import unit_of
from estimator.errors import InputError
from estimator.rig import Channel, Rig
from estimator.rig_log import Csv, Log

_TIMES = {"t", "time", "times", "timestamp", "zeit", "zeitstempel", "elapsed", "datetime", "datum", "date", "uhrzeit"}
_STEADY = 0.95  # share of the steps of times that go one way
_FIRST = 40  # rows that show what a column is
_RULES = (  # tried where a CSV can be read in two ways: what comes first is taken, and said
    Csv(),
    Csv(decimal=","),
    *(Csv(time_format=f"%{a}{mark}%{b}{mark}%Y %H:%M:%S") for mark in "/-" for a, b in ("dm", "md")),
    *(Csv(time_format=f"%{a}/%{b}/%Y %I:%M:%S %p") for a, b in ("md", "dm")),
    *(Csv(time_format=f"%{a}{mark}%{b}{mark}%Y %H:%M") for mark in "/-" for a, b in ("dm", "md")),
)
_LONG_S, _LONGEST_S = 120.0, 10 * 86400.0  # from row to row, and of a run: longer ones are counted in something shorter


@dataclass(frozen=True)
class LabTable:
    """What a lab CSV holds, or an MF4, whose signals have times of their own.

    time_column  as rig.toml has to call it      csv   what its reader has to be told, with `guessed` for whom it is
    empty        columns without a number
    """

    path: Path
    seen: tuple[Seen, ...]
    empty: tuple[str, ...]
    time_column: str = Log.time_column
    csv: Csv = _RULES[0]
    guessed: str = ""


def is_lab_table(path: Path) -> bool:
    """Whether a recording has its signals by their names, and no frames."""
    return is_lab_csv(path) or is_decoded(path)


def read_lab_table(path: Path, tally: Tally, told: Csv = _RULES[0]) -> LabTable:
    """Read a CSV of which only its own names are known, and what its reader was `told`; or the signals of an MF4.

    One that cannot be read in any way is an InputError.
    """
    if is_decoded(path):
        return _of_signals(path)
    sheet = read_sheet(path, Csv(), (), Tally(), Budget())
    if not sheet.rows:
        names = f"below the names {', '.join(sheet.names[:6])}" if sheet.names else "and no names"
        raise InputError(f"{path}: no rows {names}; expected a line of names and one row per instant")
    if sheet.nameless:
        raise InputError(f"{path}: {NAMELESS}")
    time = _time_column(sheet)
    units = {name: unit_in_tail(name) for name in sheet.names}
    first: InputError | None = None
    for rule in dict.fromkeys((told, *_RULES)):
        try:
            csv, tick_s, guessed = _timing(sheet, time, rule)
            table = Table(path, _rig(sheet, time, csv, tick_s), tally, Budget())
        except InputError as error:
            first = first or error
            continue
        units |= {name: unit for name, unit in table.units.items() if unit}
        return _told(path, time, table, units, csv, guessed or _said(rule))
    assert first is not None
    raise first


def _told(path: Path, time: str, table: Table, units: dict[str, str], csv: Csv, guessed: str) -> LabTable:
    seen = []
    for name, value in table.columns.items():
        known = np.isfinite(value) & np.isfinite(table.time)
        if known.any():
            seen.append(Seen(name, units.get(name, ""), table.time[known], value[known]))
    empty = tuple(name for name in table.columns if name not in {one.source for one in seen})
    return LabTable(path, tuple(seen), empty, time, csv, guessed)


def _of_signals(path: Path) -> LabTable:
    every = every_signal(path)
    seen = [
        Seen(name, unit_of(one.unit) or one.unit or unit_in_tail(name), one.timestamps, one.samples.astype(float))
        for name, one in every.items()
        if one is not None
    ]
    return LabTable(path, tuple(seen), tuple(name for name, one in every.items() if one is None))


def _rig(sheet: Sheet, time: str, csv: Csv, tick_s: float) -> Rig:
    """A rig that reads every column but the times, in whatever unit."""
    free = [name for k, name in enumerate(sheet.names) if name and name != time and not kind_in(sheet, k)]
    return Rig("new", tick_s, {name: Channel(unit="") for name in free}, {}, log=Log(time_column=time, csv=csv))


def _time_column(sheet: Sheet) -> str:
    """The column of the times: a stamp, else a clock or date, else what is called so, else the first that rises."""
    for kind in ("stamp", "clock", "date"):
        for k, name in enumerate(sheet.names):
            if kind_in(sheet, k) == kind:
                return name
    rising = list(_rising(sheet))
    named = [name for name in rising if {*tokens(name)} & _TIMES]
    if not rising:
        raise InputError(f"{sheet.path}: no column of times among {', '.join(sheet.names[:8])}")
    return (named or rising)[0]


def _rising(sheet: Sheet) -> Iterator[str]:
    """Columns that rise, or fall, and are in no unit of something else."""
    for name in filter(None, sheet.names):
        if measure(unit_in_tail(name)) is not None:
            continue
        with suppress(InputError):
            count = _counted(sheet, name, Csv())
            steps = np.diff(count[np.isfinite(count)])
            if (steps != 0).any() and max(np.mean(steps >= 0), np.mean(steps <= 0)) > _STEADY:
                yield name


def _counted(sheet: Sheet, name: str, rule: Csv) -> Array:
    """The numbers of a column, (n,)."""
    cells = sheet.column(sheet.names.index(name))
    return numbers(cells, rule.decimal or decimal_mark(cells, sheet.separator, sheet.path))


def _timing(sheet: Sheet, time: str, rule: Csv) -> tuple[Csv, float, str]:
    """What the reader has to be told of the times, how far rows are apart in s, and what of it is guessed."""
    if kind_in(sheet, sheet.names.index(time)):
        return rule, 1.0, ""
    count = _counted(sheet, time, rule)
    known = count[np.isfinite(count)]
    step = counting.usual_step(known)
    if not step:
        return rule, 1.0, ""
    for _, _, size in counting.dated(known.min(), known.max()):
        return rule, step * size, ""
    named = unit_of(unit_in_tail(time)) or counting.unit_in_name(time)
    if named in counting.SECONDS and named != "s":
        return rule, step * counting.SECONDS[named], ""
    if step < 0.5 and known.min() > 20_000 and known.max() < 80_000:
        return rule, step * counting.SECONDS["d"], ""
    if step > _LONG_S and (step % 10 == 0 or step * len(known) > _LONGEST_S):
        return replace(rule, time_unit="ms"), step * 1e-3, "times in ms"
    return rule, step, ""


def _said(rule: Csv) -> str:
    told = {key: value for key, value in vars(rule).items() if value != getattr(Csv(), key)}
    return ", ".join(f"{key} {value}" for key, value in told.items())
