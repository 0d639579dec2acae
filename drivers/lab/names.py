"""Names of columns and their units, as people and loggers write them."""

from __future__ import annotations

import difflib
import re
from collections.abc import Collection

_UNIT = re.compile(r"[\[(<{](.*?)[\])>}]")
_FILLING = re.compile(r"[\s_\-.#%:\"']")

_SAME = {  # what is meant, and how it is written
    "degC": "c °c ºc degc celsius ℃ degree_c deg_c",
    "K": "k kelvin",
    "degF": "f °f ºf degf fahrenheit",
    "mK": "mk",
    "mV": "mv",
    "V": "v",
    "W": "w watt",
    "kW": "kw",
    "mW": "mw",
    "mm": "mm",
    "um": "um µm μm micron",
    "m": "m",
    "rpm": "rpm 1/min min-1 u/min r/min",
    "rad/s": "rad/s",
    "A": "a",
    "s": "s sec secs second seconds sek sekunden",
    "ms": "ms msec millisecond milliseconds",
    "us": "us µs μs usec microsecond microseconds",
    "ns": "ns nanosecond nanoseconds",
    "min": "min mins minute minutes minuten",
    "h": "h hr hour hours stunden std",
    "d": "d day days tage",
}
UNITS = {word: unit for unit, words in _SAME.items() for word in words.split()}
_KINDS = ("degC K degF mK mV V", "W kW mW", "mm um m", "rpm rad/s")


def bare(name: str) -> str:
    """A name without its unit, blanks and case."""
    return _FILLING.sub("", _UNIT.sub("", name)).casefold()


def known_as(name: str, wanted: str) -> bool:
    """Whether both are the same but for unit, blanks and case."""
    return bare(name) == bare(wanted) != ""


def unit_in(name: str) -> str | None:
    """The unit in brackets, as `UNITS` has it, or behind the last underscore of a name of a time."""
    match = _UNIT.search(name)
    return unit_of(match[1]) if match else None


def unit_of(text: str) -> str | None:
    """A unit as it is meant; None for what is none."""
    return UNITS.get(text.strip().strip("[]()").replace(" ", "_").casefold())


def contradicts(said: str, expected: str) -> bool:
    """Whether both are units of one kind of quantity, and not the same."""
    meant = UNITS.get(expected.casefold(), expected)
    return said != meant and any(said in kind.split() and meant in kind.split() for kind in _KINDS)


def nearest_name(name: str, names: Collection[str]) -> str:
    """The one of these names that looks most like it; empty if none does."""
    found = difflib.get_close_matches(bare(name), [bare(other) for other in names], 1, 0.6)
    return next((other for other in names if found and bare(other) == found[0]), "")
