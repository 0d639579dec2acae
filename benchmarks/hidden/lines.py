"""A line of JSON for every case that was done, so that a study that was stopped goes on where it was."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from pathlib import Path
from time import perf_counter

from benchmarks.hidden.cases import Case
from benchmarks.hidden.judge import right
from benchmarks.hidden.outcome import Outcome
from benchmarks.hidden.study import study
from benchmarks.measure import commit, say

LINES = Path(__file__).parents[1] / "hidden.jsonl"
CHANGED = "and changes"  # since the commit: what such a tree has found says nothing of the next one


def known(of: str, lines: Path) -> Iterator[tuple[Case, Outcome]]:
    """What the lines of a commit say, the last ones last."""
    for line in lines.read_text().splitlines() if lines.exists() and CHANGED not in of else ():
        said = json.loads(line)
        if said["commit"] == of:
            yield Case(**said["case"]), Outcome(**said["outcome"])


def line_of(of: str, case: Case, out: Outcome) -> str:
    """A case as a line."""
    return json.dumps({"commit": of, "case": asdict(case), "outcome": asdict(out)})


def outcomes(cases: Sequence[Case], processes: int | None = None) -> dict[Case, Outcome]:
    """What came out of each case; what the file of lines holds is not done again."""
    of = commit()
    found = {case: out for case, out in known(of, LINES) if case in set(cases)}
    todo, began = [case for case in cases if case not in found], perf_counter()
    with ProcessPoolExecutor(processes or os.cpu_count()) as pool, LINES.open("a") as file:
        at_work = {pool.submit(study, case): case for case in todo}
        for n, done in enumerate(as_completed(at_work), start=1):
            case, out = at_work[done], done.result()
            found[case] = out
            file.write(line_of(of, case, out) + "\n")
            file.flush()
            left_min = (perf_counter() - began) / n * (len(todo) - n) / 60.0
            say(f"{n} of {len(todo)}, {left_min:.0f} min left: {told(case, out)}")
    return {case: found[case] for case in cases}


def told(case: Case, out: Outcome) -> str:
    """A case in one line."""
    mark = "right" if right(case, out) else "WRONG"
    where = f"{out.place_mm:.0f} mm {out.follows}" if out.place_mm is not None else f"{out.channel} {out.follows}"
    parts = [" + ".join(case.hidden.names), out.verdict, " ".join([*out.said, *out.wrong]), where.strip(), out.error]
    return f"{mark}  {case} (machine {case.machine}): {'; '.join(part for part in parts if part)}, {out.seconds:.0f} s"
