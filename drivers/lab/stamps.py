"""Times of a CSV as text: dates in any order of day and month, times of day, or both, to seconds.

An order of day and month that the dates leave open, where it matters, is refused and never guessed.
"""

import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, date, datetime, timedelta, timezone

import numpy as np

from drivers.frames import Array
from estimator.errors import InputError

_DATE = r"(?P<date>(?P<a>\d{1,4})(?P<mark>[./-])(?P<b>\d{1,2})(?P=mark)(?P<c>\d{1,4})\.?)"
_CLOCK = (
    r"(?:(?P<days>\d+) days? )?(?P<hour>\d{1,3}):(?P<minute>\d{1,2})(?::(?P<second>\d{1,2}(?:[.,:]\d{1,9})?))?"
    r"\s*(?P<half>[AaPp]\.?[Mm]\.?)?"
)
_WEEKDAY = r"(?:[^\W\d_]{2,10}[.,]?\s+)?"
_ZONE = r"\s*(?P<zone>Z|UTC|GMT|[+-]\d{2}(?::?\d{2})?)"
_STAMP = re.compile(
    rf"{_WEEKDAY}(?:{_DATE})?(?: - |[ T,;_]*)(?:{_CLOCK})?(?:{_ZONE}| [A-Z]{{3,5}}| Uhr)?"
)  # letters as CEST: local time
_WORDS = re.compile(r"(?=.*\d)(?=.*[A-Za-z]{3}).*|\d{8}[T _-]\d{4,}.*")  # a month in letters, or ISO without marks
_MINUTES = re.compile(r"\d{1,3}:\d{2}[.,]\d{1,6}")  # 59:05.0, as Excel shows and saves times
_LAST_CENTURY = 69  # years of two digits from that one on, as strptime has them
_EPOCH = date(1970, 1, 1).toordinal()
DAY_S, HOUR_S = 86400.0, 3600.0
_ORDERS = {"ymd": "year first", "dmy": "day first", "mdy": "month first"}
_FORMATS = {"ymd": "%y{0}%m{0}%d", "dmy": "%d{0}%m{0}%y", "mdy": "%m{0}%d{0}%y"}


@dataclass(frozen=True)
class Stamps:
    """Times in seconds, (n,), NaN where a cell is none; `local`: of a day, in no zone; `said` in which form."""

    time: Array
    local: bool
    said: str


def kind_of(cell: str) -> str:
    """ "date", "clock" or "stamp" (both), "" for what is none of them."""
    match = _matched(cell)
    if match and (match["date"] or match["hour"]):
        return "stamp" if match["date"] and match["hour"] else "date" if match["date"] else "clock"
    return "stamp" if _WORDS.fullmatch(cell) and _by_words(cell) else ""


def stamps(cells: Sequence[str], time_format: str | None, tick_s: float, where: Callable[[int], str]) -> Stamps:
    """Read the cells of a time column as text, a row about each `tick_s`; `where` names a cell's place in an error."""
    if time_format:
        return _in_format(cells, time_format)
    found = map(_matched, cells)
    matches = [match if match and (match["date"] or match["hour"]) else None for match in found]
    days, order = _days(matches, cells, where)
    clock = np.array([np.nan if match is None else _clock(match) for match in matches])
    time = days * DAY_S + clock
    words = {k: _by_words(cells[k]) for k, m in enumerate(matches) if m is None and _WORDS.fullmatch(cells[k])}
    for k, said in words.items():
        time[k] = np.nan if said is None else _seconds(said)
    shown = next((m[0] for m in matches if m), "")
    zoned = any(m and m["zone"] for m in matches) or any(said and said.tzinfo for said in words.values())
    if not order:
        short = any(matches) and not any(match and match["second"] for match in matches)
        known = np.isfinite(time)
        what = f"{where(0)}: '{cells[0]}'" if cells else ""
        time[known], form = _over_midnight(time[known], tick_s if short else 0.0, what)
        return Stamps(time, not zoned, f"times as {shown}{form}" if shown else "")
    plain = order == "ymd" or not shown
    return Stamps(
        time, not zoned, "" if plain else f"times as {shown}" + (f", {_ORDERS.get(order, order)}" if order else "")
    )


def _over_midnight(time: Array, tick_s: float, what: str) -> tuple[Array, str]:
    """Times of day, (n,) s, going on over midnight, and their form in words.

    tick_s  where they are of two numbers, such as 12:05: by it they are hours and minutes or minutes and seconds
    """
    steps = np.abs(np.diff(np.unwrap(time, period=DAY_S)))
    usual = float(np.median(steps[steps > 0]) * np.mean(steps > 0)) if steps.any() else tick_s
    ticks = usual / tick_s if tick_s else 1.0
    if 0.8 < ticks / 60 < 1.25:
        return np.unwrap(time / 60, period=HOUR_S), ", minutes and seconds"
    if 0.8 < ticks < 1.25:
        return np.unwrap(time, period=DAY_S), ""
    raise InputError(
        f'{what} is of hours or of minutes? Say time_format = "%H:%M" or "%M:%S" in csv of [log] in rig.toml'
    )


def _matched(cell: str) -> re.Match[str] | None:
    return _STAMP.fullmatch(f"0:{cell}" if _MINUTES.fullmatch(cell) else cell)


def _in_format(cells: Sequence[str], time_format: str) -> Stamps:
    time = np.full(len(cells), np.nan)
    for k, cell in enumerate(cells):
        with suppress(ValueError):
            time[k] = _seconds(datetime.strptime(cell, time_format))
    if "%d" not in time_format and "%j" not in time_format:
        period = DAY_S if "%H" in time_format or "%I" in time_format else HOUR_S
        time[np.isfinite(time)] = np.unwrap(time[np.isfinite(time)], period=period)
    return Stamps(time, "%z" not in time_format, "")


def _seconds(time: datetime) -> float:
    return (time if time.tzinfo else time.replace(tzinfo=UTC)).timestamp()


def _by_words(cell: str) -> datetime | None:
    """A time such as 1-Mar-2026 12:00:05 or 20260301T120005; None if it is none. Of letters as CEST: local time."""
    from dateutil import parser  # late: only such cells need it

    with suppress(ValueError):
        return datetime.fromisoformat(cell)
    with suppress(ValueError, OverflowError):
        return parser.parse(cell, dayfirst=True, default=datetime(1970, 1, 1), tzinfos=_zone)
    return None


def _zone(letters: str | None, ahead_s: int | None) -> timezone | None:
    return None if ahead_s is None else timezone(timedelta(seconds=ahead_s))


def _clock(match: re.Match[str]) -> float:
    """Seconds of the day, less those that its zone is ahead."""
    hour, minute = int(match["hour"] or 0), int(match["minute"] or 0)
    if half := (match["half"] or "")[:1].casefold():
        hour = hour % 12 + 12 * (half == "p")
    second = float(re.sub("[,:]", ".", match["second"] or "0"))
    zone = (match["zone"] or "Z").replace(":", "")
    sign, digits = zone[0], zone[1:].ljust(4, "0")
    ahead = int(digits[:2]) * 3600 + int(digits[2:]) * 60 if sign in "+-" else 0
    valid = minute < 60 and second < 61 and (hour < 25 or not match["date"])
    hour += 24 * int(match["days"] or 0)
    return hour * 3600 + minute * 60 + second - (-ahead if sign == "-" else ahead) if valid else np.nan


def _days(matches: list[re.Match[str] | None], cells: Sequence[str], where: Callable[[int], str]) -> tuple[Array, str]:
    """Days since 1970 of each cell, (n,), and in which order they are written; 0 and "" where there are only clocks."""
    first = {m["date"]: m for m in matches if m and m["date"]}
    if not first:
        return np.zeros(len(matches)), ""
    read = {order: {text: _day(m, order) for text, m in first.items()} for order in _ORDERS}
    # a single cell that is no date must not decide: an order is possible that reads as many as any
    most = max(sum(day is not None for day in of.values()) for of in read.values())
    possible = {order: of for order, of in read.items() if most and sum(day is not None for day in of.values()) == most}
    ways = {tuple(_since_first([*of.values()])) for of in possible.values()}
    if len(ways) > 1:
        text, match = next(iter(first.items()))
        k = next(k for k, m in enumerate(matches) if m and m["date"] == text)
        formats = " or ".join(_format(order, match) for order in possible)
        raise InputError(
            f"{where(k)}: in '{cells[k]}' day or month may come first: say time_format = {formats} "
            "in csv of [log] in rig.toml"
        )
    order = next(iter(possible), "ymd")
    days = possible.get(order, {})
    order = order if len(possible) < 2 else "all of one day"
    read_as = {text: np.nan if day is None else day for text, day in days.items()}
    return np.array([np.nan if m is None else read_as.get(m["date"], np.nan) for m in matches], dtype=float), order


def _since_first(days: list[int | None]) -> list[int | None]:
    first = next(day for day in days if day is not None)
    return [None if day is None else day - first for day in days]


def _day(match: re.Match[str], order: str) -> int | None:
    """Days since 1970 of a date written in this order; None where it cannot be."""
    parts = dict(zip(order, (match["a"], match["b"], match["c"]), strict=True))
    long = {key for key, text in parts.items() if len(text) > 2}
    if long - {"y"} or len(parts["y"]) not in (2, 4) or (order != "dmy" and match["mark"] == "." and "y" not in long):
        return None
    if match["mark"] == "." and order == "mdy":
        return None
    year = int(parts["y"])
    if len(parts["y"]) < 3:
        year += 2000 if year < _LAST_CENTURY else 1900
    with suppress(ValueError):
        return date(year, int(parts["m"]), int(parts["d"])).toordinal() - _EPOCH
    return None


def _format(order: str, match: re.Match[str]) -> str:
    """The strptime format of such a stamp."""
    text = _FORMATS[order].format(match["mark"])
    text = text.replace("%y", "%Y") if "y" in order and max(len(match["a"]), len(match["c"])) == 4 else text
    clock = "" if not match["hour"] else " %I:%M:%S %p" if match["half"] else " %H:%M:%S"
    return f'"{text}{clock}"'
