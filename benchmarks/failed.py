"""Rows of the study of failing channels (`faults`): its cases, what became of each, and how they are told."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks import paper_rig
from benchmarks.injected import FAILURES
from benchmarks.measure import Row, section

SEED = 311
WHEN = {"at rest": ("FS-20", 1800.0), "driving": ("FS-5", 400.0)}
SOON_S = 60.0


@dataclass(frozen=True)
class Case:
    """A failure of some channels at a time of a run; `row` is the row of the table, `seed` that of dice and rig."""

    row: str
    run: str
    at_s: float
    kind: str
    channels: tuple[int, ...]
    seed: int


@dataclass(frozen=True)
class Outcome:
    """What became of a case.

    um        most that the failure has added to the error of the elongation
    in_2sd    share of ticks in which the truth is within 2 sd
    named_s   when all of its channels had been named with a right word, or were said to drift perhaps, or most zeros to
              be others, inf: never
    accused   how many others were, the position among them;   suspected: how many were said to drift perhaps
    suspected_share  of the hours of all others, those in which they were
    lost_s    longest time that the estimate was off by more than 5 sd and 0.5 um
    sd_um     of the estimate, mean over the ticks
    band_um   how much wider the band of the error is than that of the healthy run
    """

    um: float
    in_2sd: float
    named_s: float
    accused: int
    lost_s: float
    suspected: int
    suspected_share: float
    sd_um: float
    band_um: float = 0.0


def share(good: Sequence[bool]) -> tuple[str, float]:
    return f"{sum(good)} of {len(good)}: {np.mean(good):.1%}", float(np.mean(good))


def cells(found: dict[Case, Outcome], name: str, must: tuple[float, float]) -> Iterator[Row]:
    """The rows of one failing channel, for 15 or seven of them."""
    some = {case: outcome for case, outcome in found.items() if case.row == name}
    least, small = must
    yield Row(
        f"{name}: share of cells with <= {small:g} um", *share([o.um <= small for o in some.values()]), least, True
    )
    worst = max(outcome.um for outcome in some.values())
    yield Row(f"{name}: largest, um", f"{worst:.2f}", worst, 0.5)
    inside = float(np.mean([outcome.in_2sd for outcome in some.values()]))
    yield Row(f"{name}: truth in 2 sd, share of ticks", f"{inside:.1%}", inside, 0.93, True)
    yield named(name, list(some.values()))
    healthy = len(some) * (len(paper_rig.rig().thermometers) - 1)
    accused = sum(outcome.accused for outcome in some.values()) / healthy
    yield Row(f"{name}: healthy channels accused", f"{accused:.1%}", accused, 0.01)
    suspected = sum(outcome.suspected for outcome in some.values()) / healthy
    yield Row(f"{name}: healthy channels said to drift perhaps for a time", f"{suspected:.1%}")
    lost = max(outcome.lost_s for outcome in some.values())
    yield Row(f"{name}: off by more than 5 sd and 0.5 um, longest, s", f"{lost:.0f}", lost, 2.0)


def named(name: str, some: Sequence[Outcome]) -> Row:
    soon = [outcome.named_s <= SOON_S for outcome in some]
    return Row(f"{name}: named with its kind within {SOON_S:.0f} s", *share(soon), 0.98, True)


def by_kind(found: dict[Case, Outcome]) -> list[str]:
    """Of each failure: error and time to its name, median and worst."""
    rows = [["", "um, median", "worst", "named after s, median", "worst"]]
    for kind in (*FAILURES, "swapped"):
        some = [outcome for case, outcome in found.items() if case.row in WHEN and case.kind == kind]
        um, s = [o.um for o in some], [o.named_s for o in some]
        rows.append([kind, f"{np.median(um):.2f}", f"{max(um):.2f}", f"{np.median(s):.0f}", f"{max(s):.0f}"])
    return [section("Failures one by one, fifteen channels", rows, level=3)]
