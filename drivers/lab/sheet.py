"""A CSV as a sheet of text cells: encoding, separator, the line of names and the line of units found by themselves.

The line of names is the one that names the most of what the rig file asks for, in whichever separator; where nothing is
asked for, the one with the most names of columns of numbers.
"""

import codecs
import csv
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path

from drivers.budget import Budget
from drivers.frames import Tally
from drivers.lab.names import bare, known_as
from drivers.lab.numerals import is_numeric
from estimator.errors import InputError
from estimator.rig_log import Csv

SEPARATORS = {",": "','", ";": "';'", "\t": "tabs", "|": "'|'", " ": "spaces"}
_WORDS = {"tab": "\t", "space": " "}
_HEAD = 100  # lines among which the one with the names is looked for
_BELOW = 12  # lines from the names on that show what the columns hold
_BOMS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF32_LE: "utf-32"}  # this begins as one of UTF-16 does
_BOMS |= {codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}


@dataclass
class Sheet:
    """Text cells of a table.

    names  (m,) of the columns          rows   (n, m) cells below them
    line   of each row, (n,)            said   what was recognised, in words
    """

    path: Path
    separator: str
    names: list[str]
    rows: list[list[str]]
    line: list[int]
    said: list[str]

    def column(self, index: int) -> list[str]:
        """The cells of one column, (n,)."""
        return [row[index].strip() for row in self.rows]

    @property
    def nameless(self) -> bool:
        """Whether numbers stand where the names should."""
        return any(self.names) and all(is_numeric(name) for name in self.names if name)


def read_sheet(path: Path, rule: Csv, wanted: Collection[str], tally: Tally, budget: Budget) -> Sheet:
    """Read a CSV; what it has too many or too few cells of is counted."""
    encoding = rule.encoding or encoding_of(path)
    try:
        with path.open(encoding=encoding, errors="replace", newline="") as file:
            lines = whole_lines(file, tally, budget)
            head = list(islice(lines, max(_HEAD, rule.skip + 1)))
            separator, at = _names_at(head, rule, wanted)
            reader = csv.reader(chain(head[at:], lines), delimiter=separator, skipinitialspace=True)
            names = [" ".join(cell.splitlines()).strip().lstrip("#").strip() for cell in next(reader, [])]
            while names and not names[-1]:
                names.pop()
            sheet = Sheet(path, separator, names, [], [], _said(separator, encoding, at))
            _fill(sheet, reader, at, budget.frames // max(len(names), 1), tally)
    except LookupError:
        raise InputError(f"{path}: rig.toml's log.csv.encoding: no encoding '{rule.encoding}'") from None
    except csv.Error as error:
        raise InputError(f"{path}: no CSV: {error}; expected cells between separators and a line of names") from None
    return sheet


def _said(separator: str, encoding: str, at: int) -> list[str]:
    said = [] if separator == "," else [f"{SEPARATORS.get(separator, separator)} between cells"]
    said += [encoding] if encoding not in ("utf-8", "utf-8-sig") else []
    return said + ([f"names in line {at + 1}"] if at else [])


def _fill(sheet: Sheet, reader: Iterator[list[str]], at: int, most: int, tally: Tally) -> None:
    width = len(sheet.names)
    odd: list[int] = []
    known = {*sheet.names} - {""}
    for row in islice(reader, most):
        if len(row) == width - 1 and sheet.names[-1] == "Comment":
            row.append("")  # LabVIEW writes no cell where there is none
        if not known.isdisjoint(row) and not any(map(is_numeric, row)) and 2 * len(known & {*row}) > len(known):
            if row[:width] != sheet.names or any(row[width:]):
                raise InputError(
                    f"{sheet.path}: line {reader.line_num + at} has other names than line {at + 1}: "  # type: ignore[attr-defined]
                    "split the file there"
                )
            tally.skip("line of names, again")
        elif any(row[:width]) and len(row) >= width and not any(map(str.strip, row[width:])):
            sheet.rows.append(row[:width])
            sheet.line.append(reader.line_num + at)  # type: ignore[attr-defined]
        elif any(map(str.strip, row)):
            odd.append(len(row))
    tally.skip("row with a wrong number of cells", len(odd))
    if not sheet.rows and odd:
        more = ": with commas in numbers, cells need another separator or quotes" if sheet.separator == "," else ""
        raise InputError(
            f"{sheet.path}: {width} names but {odd[0]} cells in a row{more}; else a name is missing or too much"
        )


def encoding_of(path: Path) -> str:
    """By its first bytes; what is no UTF-8 is from an old Windows."""
    with path.open("rb") as file:
        start = file.read(1 << 16)
    for bom, name in _BOMS.items():
        if start.startswith(bom):
            return name
    zeros = start[:200:2].count(0), start[1:200:2].count(0)
    if max(zeros) > len(start[:200]) // 4 > min(zeros):
        return "utf-16-le" if zeros[1] > zeros[0] else "utf-16-be"
    try:
        codecs.getincrementaldecoder("utf-8")().decode(start)
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8"


def _names_at(head: list[str], rule: Csv, wanted: Collection[str]) -> tuple[str, int]:
    """The separator, and the index of the line of names."""
    separators = [_WORDS.get(rule.separator, rule.separator)] if rule.separator else list(SEPARATORS)
    lines = range(rule.skip, min(rule.skip + 1, len(head))) if rule.skip else range(len(head))
    asked = {*map(bare, wanted)}

    def score(place: tuple[int, str]) -> tuple[int, int]:
        cells = next(csv.reader([head[place[0]]], delimiter=place[1], skipinitialspace=True), [])
        return len(asked & {*map(bare, cells)} - {""}), len(cells) if place[0] == lines[0] else 0

    def shape(place: tuple[int, str]) -> int:
        rows = [
            next(csv.reader([line], delimiter=place[1], skipinitialspace=True), [])
            for line in head[place[0] : place[0] + _BELOW]
        ]
        below = [row for row in rows[1:] if len(row) >= len(rows[0])]
        return sum(_names(cell, [row[k] for row in below]) for k, cell in enumerate(rows[0]))

    places = [(line, separator) for line in lines for separator in separators]
    line, separator = max(places, key=score, default=(0, ","))
    if places and not score((line, separator))[0]:  # none is asked for, or there: the error shows those that are
        line, separator = max(places, key=shape)
    return separator, line


def _names(cell: str, below: list[str]) -> bool:
    """Whether a cell is the name of a column of numbers: what is below it is most often one."""
    return bool(cell.strip()) and not is_numeric(cell) and sum(map(is_numeric, below)) * 2 > len(below)


def whole_lines(file: Iterator[str], tally: Tally, budget: Budget) -> Iterator[str]:
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


def place_of(sheet: Sheet, name: str, taken: Collection[int]) -> int | None:
    """Which column has this name, exactly or but for case, blanks and a unit; None if none has."""
    exact = [k for k, other in enumerate(sheet.names) if other == name]
    near = [k for k, other in enumerate(sheet.names) if k not in taken and known_as(other, name)]
    found = exact or near
    if len(found) > 1:
        which = " and ".join(str(k + 1) for k in found)
        told = " and ".join(f"'{sheet.names[k]}'" for k in found) if not exact else f"'{name}' stands"
        what = f"{told} in columns {which}" if exact else f"{told} could both be '{name}'"
        raise InputError(f"{sheet.path}: {what}: rename all but the one that rig.toml means")
    if found and not exact:
        sheet.said.append(f"'{sheet.names[found[0]]}' as {name}")
    return found[0] if found else None
