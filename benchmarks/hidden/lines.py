"""The cases that were done, one line each, and each in words."""

from collections.abc import Sequence
from pathlib import Path

from benchmarks import kept
from benchmarks.hidden.cases import Case
from benchmarks.hidden.judge import right
from benchmarks.hidden.outcome import Outcome
from benchmarks.hidden.study import study

LINES = Path(__file__).parents[1] / "hidden.jsonl"


def outcomes(cases: Sequence[Case], processes: int | None = None) -> dict[Case, Outcome]:
    """What came out of each case; what the file of lines holds is not done again."""
    found = {Case(**case): Outcome(**out) for case, out in kept.known(LINES)}
    return kept.outcomes(LINES, cases, found, study, told, processes=processes)


def told(case: Case, out: Outcome) -> str:
    """A case in one line."""
    mark = "right" if right(case, out) else "WRONG"
    where = f"{out.place_mm:.0f} mm {out.follows}" if out.place_mm is not None else f"{out.channel} {out.follows}"
    parts = [" + ".join(case.hidden.names), out.verdict, " ".join([*out.said, *out.wrong]), where.strip(), out.error]
    return f"{mark}  {case} (machine {case.machine}): {'; '.join(part for part in parts if part)}, {out.seconds:.0f} s"
