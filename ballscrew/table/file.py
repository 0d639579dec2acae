"""The table's file: CSV for a spreadsheet, Parquet for everything else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
from pyarrow import compute, csv, parquet

from estimator.errors import InputError

DIGITS = 6  # after the point, of what a CSV tells; Parquet keeps all


def _write_csv(rows: pa.Table, path: Path) -> None:
    rounded = [compute.round(c, DIGITS) if pa.types.is_floating(c.type) else c for c in rows.columns]
    csv.write_csv(pa.Table.from_arrays(rounded, names=rows.column_names), path)


def _write_parquet(rows: pa.Table, path: Path) -> None:
    parquet.write_table(rows, path, compression="zstd")


WRITERS: dict[str, Callable[[pa.Table, Path], None]] = {".csv": _write_csv, ".parquet": _write_parquet}


def write(rows: pa.Table, path: Path) -> None:
    """Write the table; one that cannot be written is an InputError."""
    try:
        WRITERS[path.suffix.lower()](rows, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {(error.strerror or str(error)).lower()}") from error
