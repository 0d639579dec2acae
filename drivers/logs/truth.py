"""The truth of a simulated recording: for printing errors, never for estimating."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy

from drivers.frames import Array
from estimator.errors import InputError

TABLE = re.compile(r"table_(-?[\d.]+)_um")
SPLINE = 4  # points that a cubic needs


@dataclass(frozen=True)
class Truth:
    """What really was, at K instants.

    time_s         (K,) s on the log's clock, from its first frame
    elongation_um  (K,) um, growth of the measured span since then
    channels       (K,) K per thermometer, true rise of its temperature since then
    table          (K,) um per table position in mm, growth between the anchor bearing and the nut's centre, were the
                   table there; empty where the file does not say
    """

    time_s: Array
    elongation_um: Array
    channels: dict[str, Array]
    table: dict[float, Array]

    def at(self, time_s: Array) -> Array:
        """Elongation at other instants, (n,) um: NaN outside."""
        return np.interp(time_s, self.time_s, self.elongation_um, left=np.nan, right=np.nan)

    def rises(self, names: Sequence[str], time_s: Array) -> Array:
        """True rises of these thermometers at other instants, (n, names) K: NaN for one the truth does not hold."""
        silent = np.full(len(self.time_s), np.nan)
        columns = [np.interp(time_s, self.time_s, self.channels.get(name, silent)) for name in names]
        return np.stack(columns, axis=-1)

    def at_table(self, at_mm: Array, time_s: Array) -> Array:
        """Error at the table at these places and instants, (n, p) um, by a spline between the places that are told: NaN
        beyond them, and where they are too few."""
        if len(self.table) < SPLINE:
            return np.full((len(time_s), len(at_mm)), np.nan)
        told = np.array(sorted(self.table))
        each = np.array([np.interp(time_s, self.time_s, self.table[at], np.nan, np.nan) for at in told])
        known = np.isfinite(each).all(axis=0)
        found = np.full((len(time_s), len(at_mm)), np.nan)
        found[known] = scipy.interpolate.CubicSpline(told, each[:, known])(at_mm).T
        return np.where((at_mm >= told[0]) & (at_mm <= told[-1]), found, np.nan)


def truth_path(path: Path) -> Path:
    """Where the truth of a recording would be: NAME.truth.csv beside NAME.log."""
    return path.with_name(f"{path.stem}.truth.csv")


def is_truth(path: Path) -> bool:
    """Whether a file is by its name a truth file: never a recording."""
    return path.name.lower().endswith(".truth.csv")


def read_truth(path: Path) -> Truth | None:
    """The truth beside the recording at `path`; None if there is none; a malformed one is an InputError."""
    file = truth_path(Path(path))
    if not file.is_file():
        return None
    try:
        with file.open(encoding="utf-8-sig", newline="") as text:
            lines = (row for row in csv.reader(text) if row)
            header, *rows = (np.array(row, float) if k else row for k, row in enumerate(lines))  # a day of text: 130 MB
        table = np.array(rows)
    except (OSError, ValueError, csv.Error) as error:
        raise InputError(f"{file}: cannot be read as a truth file: {' '.join(str(error).split())[:120]}") from None
    for column in ("time_s", "elongation_um"):
        if column not in header:
            raise InputError(f"{file}: no column '{column}'; expected time_s, elongation_um, T01, ...")
    if len(table) < 2 or not np.isfinite(table).all():
        raise InputError(f"{file}: expected at least two rows, all of them numbers")
    columns = dict(zip(header, table.T, strict=True))
    time_s = columns.pop("time_s")
    if (np.diff(time_s) <= 0).any():
        raise InputError(f"{file}: time_s must rise (row {int(np.argmax(np.diff(time_s) <= 0)) + 3})")
    places = {float(at[1]): columns.pop(name) for name in list(columns) if (at := TABLE.fullmatch(name))}
    return Truth(time_s, columns.pop("elongation_um"), columns, places)
