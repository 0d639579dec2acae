"""Names of columns, as people and loggers write them, and the units in them."""

import difflib
import re
from collections.abc import Collection

from drivers.units import MEASURED, unit_of

_UNIT = re.compile(r"[\[(<{](.*?)[\])>}]")
_TAIL = re.compile(r"(\s+in\s+|\s*/\s*|,?\s+)(\S+)$")  # a unit without brackets: "T1 / °C", "T1 in K", "T1 °C"
_FILLING = re.compile(r"[\s_\-.#%:\"']")


def bare(name: str) -> str:
    """A name without its unit, blanks and case."""
    name = _UNIT.sub("", name).strip()
    return _FILLING.sub("", _TAIL.sub("", name) if _in_tail(name) else name).casefold()


def known_as(name: str, wanted: str) -> bool:
    """Whether both are the same but for unit, blanks and case."""
    return bare(name) == bare(wanted) != ""


def unit_in(name: str) -> str | None:
    """The unit in brackets or at the end, as `UNITS` has it; of several the last."""
    return next(filter(None, map(unit_of, reversed(_UNIT.findall(name)))), None) or _in_tail(name.strip())


def _in_tail(name: str) -> str | None:
    """The unit that a name ends with: not one of times, for "T1 min" is the lowest, and no "Sensor C"."""
    tail = _TAIL.search(name) if " " in name or "/" in name else None  # most cells that are asked for have neither
    unit = unit_of(tail[2]) if tail else None
    return unit if tail and unit in MEASURED and (len(tail[2]) > 1 or tail[1].strip(" ,")) else None


def nearest_name(name: str, names: Collection[str]) -> str:
    """The one of these names that looks most like it; empty if none does."""
    found = difflib.get_close_matches(bare(name), [bare(other) for other in names], 1, 0.6)
    return next((other for other in names if found and bare(other) == found[0]), "")
