"""Whether what wears is named, and nothing where nothing does: machine after machine, thirty runs each.

Every case is another machine with a model fitted to four of its healthy runs, a seed a run, and runs of mixed patterns,
one a day. In one of three nothing changes; else one of its strengths rises by 12 % from a run on that the case draws,
or by a step there. Machines 1 - 20 are there to set things on (`dev`); those that judge begin at 421. Each case leaves
a line in benchmarks/trends.jsonl.

python -m benchmarks trends [0-5] [dev]
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any, NamedTuple

from benchmarks import paper_rig
from benchmarks.handed_over import simulated
from benchmarks.hidden.models import healthy_model
from benchmarks.hidden.tables import interval
from benchmarks.kept import known, outcomes
from benchmarks.measure import numbers, section
from drivers.virtual_rig.dice import dice
from estimator.record import Recording
from estimator.trend.trend import trend
from estimator.work import Runs

LINES = Path(__file__).parent / "trends.jsonl"
RUNS, LATEST, DAY_S = 30, 20, 86400.0
PATTERNS = ("FS-20", "CS-10", "FS-10", "ES-20", "CS-20", "FS-5")
WEAR = 0.12
WEARS = {  # strengths of the virtual rig, and the parameters of the model that are it, first parts will do
    "nut_friction": ("nut_friction",),
    "anchor_friction": ("anchor_friction",),
    "free_friction": ("free_friction",),
    "still_air": ("still_air.h",),
    "anchor_housing": ("anchor_housing.g",),
}
NEAR = 5  # runs
FIRST, FEW = 421, 12


class Case(NamedTuple):
    """The n-th case."""

    number: int
    dev: bool = False

    @property
    def machine(self) -> int:
        """Its machine."""
        return 1 + self.number % 20 if self.dev else FIRST + self.number

    def drawn(self, what: str, choices: int) -> int:
        """One of some choices."""
        return int(dice(self.machine, f"trend {what}").integers(choices))

    @property
    def wears(self) -> str:
        """What rises; "" for nothing."""
        return "" if self.number % 3 == 0 else list(WEARS)[self.drawn("wears", len(WEARS))]

    @property
    def since(self) -> int:
        """The first run in which it is another."""
        return 5 + self.drawn("since", LATEST - 5)

    def strength(self, run: int) -> float:
        """Of what wears, in a run."""
        if run < self.since:
            return 1.0
        step = self.drawn("shape", 2)
        return 1.0 + WEAR * (1.0 if step else (run - self.since + 1) / (RUNS - self.since))


def markdown(*words: str) -> str:
    """Run the cases that words ask for; the table."""
    cases = [Case(n, "dev" in words) for n in [n for word in words for n in numbers(word)] or range(FEW)]
    found = {Case(*case): out for case, out in known(LINES)}
    return "\n".join(_tables(outcomes(LINES, cases, found, _followed, _told)))


def _told(case: Case, out: dict[str, Any]) -> str:
    return f"{'right' if _right(case, out) else 'WRONG'} machine {case.machine}: {case.wears}; {out}"


def _followed(case: Case) -> dict[str, Any]:
    rig = paper_rig.rig()
    model = healthy_model(case.machine, rig)
    recordings = [_run(case, k) for k in range(RUNS)]
    began = process_time()
    found = trend(model, Runs(rig, recordings))
    told = [
        [one.drift.course.name, one.drift.shape, one.drift.run, one.drift.share, one.drift.p, *one.or_else]
        for one in found.told
    ]
    return {"told": told, "seconds": process_time() - began}


def _run(case: Case, run: int) -> Recording:
    pattern = PATTERNS[int(dice(case.machine, f"pattern {run}").integers(len(PATTERNS)))]
    plant = {case.wears: case.strength(run)} if case.wears else {}
    made, _ = simulated(
        pattern, paper_rig.rig(), case.machine, 1000 * case.machine + run, plant=plant, max_drive_s=1500, cycles=1,
        seconds=3600,
    )  # fmt: skip
    return replace(made, name=f"run {run}", began_s=1.7e9 + DAY_S * run)


def _right(case: Case, out: dict[str, Any]) -> bool:
    """Nothing where nothing wears; else the parameter first, or as well, within five runs."""
    if not case.wears or not out["told"]:
        return not case.wears and not out["told"]
    name, _, run, _, _, *or_else = out["told"][0]
    named = any(each.startswith(WEARS[case.wears]) for each in (name, *or_else))
    return named and abs(run - case.since) <= NEAR


def _tables(of: dict[Case, dict[str, Any]]) -> Iterator[str]:
    worn, healthy = ({c: o for c, o in of.items() if bool(c.wears) is kind} for kind in (True, False))
    rows = [
        ["", "measured", "must be"],
        ["12 % in 30 runs: the parameter named, within 5 runs", _share(worn), ">= 95 %"],
        [
            "nothing changes: something told",
            interval(sum(bool(o["told"]) for o in healthy.values()), len(healthy)),
            "<= 5 %",
        ],
    ]
    yield section("What wears, machine by machine", rows)


def _share(of: dict[Case, dict[str, Any]]) -> str:
    return interval(sum(_right(case, out) for case, out in of.items()), len(of))
