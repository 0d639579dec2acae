"""A line of JSON for every case of a study that was done, so that a study that was stopped goes on where it was."""

import json
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from pathlib import Path
from time import perf_counter
from typing import Any, TypeVar

from benchmarks.measure import commit, say

CHANGED = "and changes"  # since the commit: what such a tree has found says nothing of the next one

Case = TypeVar("Case")
Out = TypeVar("Out")


def known(file: Path) -> Iterator[tuple[Any, Any]]:
    """Cases and outcomes of the commit as lines have them, the last ones last."""
    of = commit()
    for line in file.read_text().splitlines() if file.exists() and CHANGED not in of else ():
        said = json.loads(line)
        if said["commit"] == of:
            yield said["case"], said["outcome"]


def outcomes(
    file: Path, cases: Sequence[Case], found: dict[Case, Out], study: Callable[[Case], Out],
    told: Callable[[Case, Out], str], at_once: int = 1, processes: int | None = None,
) -> dict[Case, Out]:  # fmt: skip
    """What comes out of each case; what is `found` already is not done again.

    told  says a case in words;  at_once  cases that one process does one after the other
    """
    todo, of, began = [case for case in cases if case not in found], commit(), perf_counter()
    some_at_once = [todo[k : k + at_once] for k in range(0, len(todo), at_once)]
    with ProcessPoolExecutor(processes or os.cpu_count()) as pool, file.open("a") as lines:
        at_work = [pool.submit(_done, study, some) for some in some_at_once]
        new = (one for done in as_completed(at_work) for one in done.result())
        for n, (case, out) in enumerate(new, start=1):
            found[case] = out
            lines.write(json.dumps({"commit": of, "case": case, "outcome": out}, default=asdict) + "\n")
            lines.flush()
            left_min = (perf_counter() - began) / n * (len(todo) - n) / 60.0
            say(f"{n} of {len(todo)}, {left_min:.0f} min left: {told(case, out)}")
    return {case: found[case] for case in cases}


def _done(study: Callable[[Case], Out], cases: Sequence[Case]) -> list[tuple[Case, Out]]:
    return [(case, study(case)) for case in cases]
