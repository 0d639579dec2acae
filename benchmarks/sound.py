"""Runs in which nothing fails: of the machine that the model is of, by a model that is wrong, of other machines."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from benchmarks import paper_rig
from benchmarks.failed import Outcome
from benchmarks.measure import Row, table

ROWS = ("healthy", "wrong model", "another machine")
WRONG = 0.2  # by which share every physical parameter is off
OTHERS = range(101, 105)  # machines that the shipped model is not of


def tables(found: Mapping[str, Sequence[Outcome]]) -> str:
    """The table of the outcomes of each row, where there are any."""
    rows = [row for name, some in found.items() if some for row in _rows(name, some)]
    says = f"Wrong model: every physical parameter is {WRONG:.0%} too large or too small. Another machine: numbers "
    return table("Healthy thermometers", rows, [f"{says}{OTHERS[0]} to {OTHERS[-1]}, by the model of machine 0."])


def _rows(name: str, some: Sequence[Outcome]) -> Iterator[Row]:
    """The rows of runs in which nothing fails."""
    accused = sum(o.accused for o in some)
    yield Row(f"{name}, {len(some)} runs: channels accused", str(accused), accused, 0)
    suspected, hours = sum(o.suspected for o in some), float(np.mean([o.suspected_share for o in some]))
    said = f"{suspected} of {len(some) * len(paper_rig.rig().thermometers)}, {hours:.2%} of their hours"
    yield Row(f"{name}: channels that were said to drift perhaps", said, hours, 0.01)
    inside, sd_um = [o.in_2sd for o in some], [o.sd_um for o in some]
    text = f"{np.mean(inside):.1%}; {min(inside):.1%} in the run with the least"
    yield Row(f"{name}: truth in 2 sd, share of ticks", text, float(np.mean(inside)), 0.90, True)
    lost = max(o.lost_s for o in some)
    yield Row(f"{name}: off by more than 5 sd and 0.5 um, longest, s", f"{lost:.0f}", lost, 2.0)
    yield Row(f"{name}: mean sd of a run, um, median and largest", f"{np.median(sd_um):.3f}, {max(sd_um):.3f}")
