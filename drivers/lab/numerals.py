"""Numbers of a CSV: decimal points or commas, and marks between thousands."""

import re
from collections.abc import Iterable, Sequence

import numpy as np

from drivers.frames import Array
from drivers.units import unit_of
from estimator.errors import InputError

NOTHING = frozenset({"", "nan", "null", "none", "n/a", "na", "#n/a", "-", "--", "---"})  # not measured
_ON = frozenset({"true", "on", "yes", "wahr", "ein", "an", "ja", "vrai"})
_OFF = frozenset({"false", "off", "no", "falsch", "aus", "nein", "faux"})
_WITH_UNIT = re.compile(r"[+−-]? ?\d[\d.,]*(?:[eE][+-]?\d+)?(\s*[^\s\d.,:/-]\S*)")  # "22.1 °C"
_MARKED = re.compile(r"[+-]? ?\d[\d.,]*(?:[eE][+-]?\d+)?")
_BLANK = re.compile(r"(?<=\d)[\s'’](?=\d{3})|(?<=^[+-])\s+")  # between thousands, as in French and Swiss numbers
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:[.,]\d{3})+")


def is_numeric(cell: str) -> bool:
    """Whether a cell holds a number, with whatever marks."""
    plain = without_unit(cell.strip())[0]
    return bool(plain) and plain.lower() not in NOTHING and not plain.strip("0123456789.,+-eE \t'")


def without_unit(cell: str) -> tuple[str, str]:
    """A cell and what stands behind its number, if that is a unit: "22.1 °C"."""
    match = _WITH_UNIT.fullmatch(cell)
    tail = match[1] if match and unit_of(match[1]) else ""
    return cell.removesuffix(tail), tail


def decimal_mark(cells: Iterable[str], separator: str, path: object) -> str:
    """',' or '.', by all these cells; commas that may be either are an InputError."""
    marked = [cell for cell in cells if ("," in cell or "." in cell) and _MARKED.fullmatch(cell)]
    both = [cell for cell in marked if "," in cell and "." in cell]
    if both:
        return max(",.", key=both[0].rfind)
    commas = [cell for cell in marked if "," in cell]
    points = [cell for cell in marked if "." in cell]
    if len(points) > len(commas) or not commas or (points and all(map(_THOUSANDS.fullmatch, commas))):
        return "."
    if points or separator != "," or not all(map(_THOUSANDS.fullmatch, commas)):
        return ","
    raise InputError(
        f"{path}: is '{commas[0]}' {commas[0].replace(',', '')} or {commas[0].replace(',', '.')}? "
        'say decimal = "." or decimal = "," in csv of [log] in rig.toml'
    )


def numbers(cells: Sequence[str], mark: str) -> Array:
    """The numbers in cells with this decimal mark, (n,): NaN for what is none."""
    other = "." if mark == "," else ","
    if any(mark == "," and "," in cell for cell in cells) or any(other in cell for cell in cells):
        cells = [_plain(cell, mark, other) for cell in cells]
    try:
        return np.array(cells, dtype=float)
    except ValueError:
        return np.array([_number(cell) for cell in cells])


def switched(cells: Sequence[str]) -> Array | None:
    """A column of nothing but on and off as 1 and 0, (n,): NaN where it is empty; None for any other."""
    words = [cell.lower() for cell in cells]
    said = {*words} - NOTHING
    if not said or not said <= _ON | _OFF:
        return None
    return np.array([1.0 if word in _ON else 0.0 if word in _OFF else np.nan for word in words])


def _plain(cell: str, mark: str, other: str) -> str:
    """The cell with a decimal point and no marks between thousands; a mark where none belongs makes it no number."""
    whole, _, part = cell.partition(mark)
    if other in cell and not (_THOUSANDS.fullmatch(whole) and other in whole and other not in part):
        return "?"
    return cell.replace(other, "").replace(mark, ".")


def _number(cell: str) -> float:
    try:
        return float(_BLANK.sub("", cell).replace("−", "-"))
    except ValueError:
        return np.nan
