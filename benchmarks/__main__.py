"""Run every study and write what it measured to benchmarks/RESULTS.md."""

from __future__ import annotations

import datetime
import os
import platform
from pathlib import Path

from benchmarks import accuracy, mesh, speed

RESULTS = Path(__file__).parent / "RESULTS.md"


def main() -> None:
    """Print and keep the tables."""
    machine = f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"
    lines = ["# Measured", "", f"By `make bench` on {datetime.date.today():%Y-%m-%d}; {machine}.", ""]
    for study in (accuracy, mesh, speed):
        table = study.markdown()
        print(table, flush=True)
        lines += [table, ""]
    RESULTS.write_text("\n".join(lines))


if __name__ == "__main__":
    main()
