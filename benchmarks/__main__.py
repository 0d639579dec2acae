"""Run studies and keep what they measured in benchmarks/RESULTS.md; the sections of other studies stay.

python -m benchmarks [NAME ...]          without a name: all but those that take long
python -m benchmarks machines WORD ...   a part of that study, printed and not kept; faults, hidden, trends likewise
"""

import datetime
import importlib
import re
import sys
from pathlib import Path

from benchmarks.measure import alone, commit, machine

RESULTS = Path(__file__).parent / "RESULTS.md"
STUDIES = ("accuracy", "mesh", "speed", "engine")
LONG = ("faults", "recovery", "search", "hidden", "live", "machines", "trends")
PARTS = (["machines"], ["faults"], ["hidden"], ["trends"])  # which do a part of themselves for the words after them
ALONE = ("engine", *LONG)  # in a process that computes in one thread


def main(names: list[str]) -> None:
    """Print and keep the tables."""
    if names[:1] in PARTS and not set(names[1:]) & {*STUDIES, *LONG} and names[1:]:
        print(alone(*names).strip())
        return
    if unknown := set(names) - {*STUDIES, *LONG}:
        raise SystemExit(f"no study {', '.join(unknown)}; there are {', '.join(STUDIES + LONG)}")
    for name in names or STUDIES:
        study = alone(name) if name in ALONE else importlib.import_module(f"benchmarks.{name}").markdown()
        tables = study.strip()
        print(tables, flush=True)
        _keep(name, f"*{datetime.date.today():%Y-%m-%d}, {commit()}, {machine()}*\n\n{tables}")


def _keep(name: str, text: str) -> None:
    """Put a study's text in its place in the results, or at their end; all else stays, a part of a study under its own
    name too."""
    old = RESULTS.read_text() if RESULTS.exists() else ""
    parts = re.split(r"<!-- (\w+) -->\n", old)
    kept = dict(zip(parts[1::2], parts[2::2])) | {name: text}
    texts = [f"<!-- {each} -->\n\n{kept[each].strip()}\n" for each in kept]
    RESULTS.write_text("\n".join(["# Measured\n", *texts]))


if __name__ == "__main__":
    main(sys.argv[1:])
