"""What the numbers of a time column count: seconds, parts of them, minutes, hours, days of a spreadsheet.

Its unit is what rig.toml says, else what the file says, else what the size of the numbers or their step can only be.
What may be two of these is refused and never guessed.
"""

import re
from collections.abc import Iterator

import numpy as np

from drivers.frames import Array
from drivers.lab.order import shuffled
from drivers.lab.stamps import DAY_S
from drivers.units import unit_of
from estimator.errors import InputError

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "d": DAY_S}
WORDS = {"ms": "milliseconds", "us": "microseconds", "ns": "nanoseconds", "min": "minutes", "h": "hours", "d": "days"}
_SHEET_DAYS = (20_000.0, 80_000.0)  # since 1900: from 1954 to 2119
_SHEET_ZERO = 25_569.0  # 1970-01-01 in days of a spreadsheet
_MATLAB = "days since the year 0, as Matlab has them"
_ZEROS = {  # what 1970-01-01 is counted as, and s of one count
    "": (0.0, 1.0),
    "milliseconds since 1970": (0.0, 1e-3),
    "microseconds since 1970": (0.0, 1e-6),
    "nanoseconds since 1970": (0.0, 1e-9),
    _MATLAB: (719_529.0, DAY_S),
    "100 ns since 1601, as Windows has them": (116_444_736e9, 1e-7),
    "100 ns since the year 1, as .NET has them": (621_355_968e9, 1e-7),
}
_DATES_S = (1e9, 4.2e9)  # from 2001 to 2103
_CLOSE = 0.02
_MOST, _LEAST = 30.0, 1e-3  # ticks: rows that are further apart, or closer, are more likely counted in another unit


def seconds(count: Array, tick_s: float, told: str | None, of_file: str | None, place: str) -> tuple[Array, str]:
    """Seconds of a time column's numbers, (n,), and what was recognised, in words.

    told  the unit that rig.toml says     of_file  that which a line of units or the column's name says
    """
    of_file = of_file if of_file in SECONDS else None  # a column of something else may count as one of times
    if told or (of_file and of_file != "s"):
        unit = told or of_file or "s"
        if unit == "d" and (days := _first_day(count)):
            return (count - days[1]) * DAY_S, f"times in {days[0]}"
        return count * SECONDS[unit], "" if told else f"times in {WORDS[unit]}"
    known = count[np.isfinite(count)]
    step = usual_step(known)
    if not len(known) or not step:
        return count, ""
    low, high = float(known.min()), float(known.max())
    for said, zero, size in dated(low, high):
        if _LEAST <= step * size / tick_s < _MOST:
            return (count - zero) * size, f"times in {said}" if said else ""
    in_days = _SHEET_DAYS[0] < low and high < _SHEET_DAYS[1] and step < 0.5 and not _round(step)
    if in_days and step / tick_s < _LEAST:
        return (count - _SHEET_ZERO) * DAY_S, "times in days of a spreadsheet"
    unit = _by_step(step, tick_s, in_days, place)
    return count * SECONDS[unit], "" if unit == "s" else f"times in {WORDS[unit]}: their step is the rig's tick"


def dated(low: float, high: float) -> Iterator[tuple[str, float, float]]:
    """In words, the zero and the s of a count by which all numbers from low to high are dates of this century."""
    for said, (zero, size) in _ZEROS.items():
        if _DATES_S[0] <= (low - zero) * size and (high - zero) * size < _DATES_S[1]:
            yield said, zero, size


def _first_day(count: Array) -> tuple[str, float] | None:
    """Of days that are dates of this century, in words, and what 1970-01-01 is counted as; None of a run's own days."""
    for said, zero in (("days of a spreadsheet", _SHEET_ZERO), (_MATLAB, _ZEROS[_MATLAB][0])):
        since_s = (count[np.isfinite(count)] - zero) * DAY_S
        if len(since_s) and since_s.min() >= _DATES_S[0] and since_s.max() < _DATES_S[1]:
            return said, zero
    return None


def zoneless(said: str) -> bool:
    """Whether what was recognised counts days of a place, as a spreadsheet does, and not of the world."""
    return "days of" in said or "days since" in said


def unit_in_name(name: str) -> str | None:
    """The unit at the end of a column's name, such as t_ms or "time min"."""
    _, *end = re.split(r"[\s_]+", name.strip())
    unit = unit_of(end[-1]) if end else None
    return unit if unit in SECONDS else None


def usual_step(known: Array) -> float:
    """The usual step from row to row: where rows come evenly their mean one, which rounding moves less."""
    steps = np.abs(np.diff(np.sort(known) if shuffled(known) else known))
    steps = steps[steps > 0]
    if not len(steps):
        return 0.0
    middle, mean = float(np.median(steps)), float(steps.mean())
    rows = max(round((len(known) - 1) / len(steps)), 1)  # that share a number
    return (mean if 0.8 < mean / middle < 1.25 else middle) / rows


def _by_step(step: float, tick_s: float, in_days: bool, place: str) -> str:
    """The unit in which the rows come once a tick, or seconds, where only one makes sense.

    in_days  whether the numbers may be days of a spreadsheet
    """
    ticks = step / tick_s
    unit = next((unit for unit, size in SECONDS.items() if abs(ticks * size - 1) < _CLOSE), None)
    if unit not in (None, "min") or (unit == "min" and not _round(step)):
        return str(unit)
    minutes = ticks < 1 / _MOST and (in_days or (_round(step * 60) and not _round(step)))
    if unit is None and _LEAST <= ticks <= _MOST and not minutes:
        return "s"
    other = "milliseconds or seconds" if ticks > 1 else "minutes or seconds"
    raise InputError(
        f"{place} steps by {step:.4g}, {ticks:.3g} times the rig's tick of {tick_s:g} s: {other}? "
        'say time_unit = "s", "ms", "min" or "d" in csv of [log] in rig.toml'
    )


def _round(step: float) -> bool:
    """Whether it is a step that a logger is set to: two digits."""
    return bool(abs(float(f"{step:.2g}") / step - 1) < 1e-3)
