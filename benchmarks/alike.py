"""Heat that the model lacks, and two neighbours that drift alike: what looks like the other, and what becomes of it.

Limits were set on heat of seeds 1 to 6 (CS-20), 13 and 15 (FS-10), and on pairs of FS-20 and FS-5 with seed 311, which
are asked here again, T11 with T12 and T13 with T14 but for the first time; 21 to 25 (CS-10) judge the heat.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields

import numpy as np

from benchmarks import handed_over, paper_rig
from benchmarks.drifts import LOST_SD, LOST_UM, longest
from benchmarks.injected import failing
from benchmarks.lies import valid
from benchmarks.measure import say, section
from estimator.batch.replay import replay
from estimator.faults.fault import Fault
from estimator.record import Array, Recording

HEATS = {"parked_chips": 2.0, "local_heat": 1.0, "rubbing_cover": 1.0, "slow_blast": 1.0}
RUN, SEEDS = "CS-10", range(21, 26)
PAIRS = ((0, 1), (2, 3), (4, 5), (6, 7), (9, 10), (10, 11), (12, 13))
HEAD = ("", "cases", "um, most", "um, valid", "lost, s", "lost while valid, s", "others accused", "both named after s")


@dataclass(frozen=True)
class Found:
    """What becomes of a case: most that the estimate is off by, ever and while valid, um; for how long it is lost, ever
    and while valid, s; how many are accused that are well; when all that are not are named or suspected, inf: never."""

    um: float
    valid_um: float
    lost_s: float
    lost_valid_s: float
    accused: int
    named_s: float


def found(recording: Recording, true_um: Array, wrong: tuple[int, ...] = (), at_s: float = 0.0) -> Found:
    """One case, of which some thermometers go wrong from a time on."""
    rig = paper_rig.rig()
    track = replay(paper_rig.model(), rig, recording)
    now = (track.time_s >= at_s) & np.isfinite(track.elongation_um)
    error, trusted = np.where(now, abs(true_um - track.elongation_um), 0.0), valid(recording, track, rig) & now
    lost = now & (error > np.maximum(LOST_SD * track.sigma_um, LOST_UM))
    accused = (track.fault > Fault.JUDGED) & now[:, None]
    said = (accused | (track.may_drift_K != 0.0)) & now[:, None]
    first = [track.time_s[said[:, i]].min(initial=np.inf) - at_s for i in wrong]
    return Found(
        float(error.max()), float(error[trusted].max(initial=0.0)), longest(lost) * rig.tick_s,
        longest(lost & trusted) * rig.tick_s, int(np.delete(accused.any(axis=0), wrong).sum()),
        max(first, default=np.nan),
    )  # fmt: skip


def table(when: Mapping[str, tuple[str, float]], seed: int) -> str:
    """All cases; the pairs at those times of those runs."""
    return section("Heat, or a drift", [HEAD, *_rows(when, seed)], level=3)


def _rows(when: Mapping[str, tuple[str, float]], seed: int) -> Iterator[list[str]]:
    for name, size in HEATS.items():
        runs = [handed_over.simulated(RUN, paper_rig.rig(), seed=own, plant={name: size}) for own in SEEDS]
        yield _row(f"{name} x {size:g}, {RUN}", [found(*run) for run in runs])
    for words, (run, at_s) in when.items():
        recording, true_um = handed_over.simulated(run, paper_rig.rig(), seed=seed)
        drifting = [(failing(recording, "drift", pair, at_s, seed), true_um, pair, at_s) for pair in PAIRS]
        yield _row(f"two neighbours drift by 3 K/h, {words}", [found(*each) for each in drifting])


def _row(name: str, cases: list[Found]) -> list[str]:
    """One row of the table: the worst of its cases, and how many are accused in all."""
    columns = {each.name: [getattr(case, each.name) for case in cases] for each in fields(Found)}
    say(f"  {name}: {columns}")
    um = [f"{max(columns[key]):.2f}" for key in ("um", "valid_um")]
    lost = [f"{max(columns[key]):.0f}" for key in ("lost_s", "lost_valid_s")]
    named_s = max(columns["named_s"])
    named = "" if np.isnan(named_s) else f"{named_s:.0f}"
    return [name, str(len(cases)), *um, *lost, str(sum(columns["accused"])), named]
