"""A displacement, a position or a speed that lies: what becomes of the estimate, while it is sent as valid.

Limits of lengths were set on machines 0 to 14 with seeds 101 to 103, those of a position's shift on 0, 21 to 37, 64 and
121 to 128 with seed 205: machines 27 and 28 are no strangers to the latter, but for their seed.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from functools import lru_cache

import numpy as np

from benchmarks import handed_over, paper_rig
from benchmarks.drifts import LOST_SD, LOST_UM, longest
from benchmarks.measure import say, section
from drivers.virtual_rig import Run, simulate
from estimator.alarms.alarms import Alarms
from estimator.alarms.trust import Watch
from estimator.batch.replay import replay
from estimator.faults.fault import Fault
from estimator.faults.travel import disagreements
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.step import Track

MACHINES, SEED = (0, 27, 28), 311  # all by the model of machine 0
WHEN = (("FS-20", 100.0), ("CS-10", 300.0), ("FS-5", 400.0))
LENGTHS: dict[str, Callable[[Array, float], Array]] = {  # readings from a time on, and the last before it
    "displacement stuck": lambda reading, last: 0.0 * reading + last,
    "displacement x 1.2": lambda reading, _: 1.2 * reading,
    "displacement x 1.2 from there on": lambda reading, last: last + 1.2 * (reading - last),
    "displacement the other way": lambda reading, last: 2.0 * last - reading,
    "displacement + 2 um": lambda reading, _: reading + 2.0,
}
DRIVES: dict[str, dict[str, handed_over.Lie]] = {
    "position in inches": {"position": lambda mm: mm / 25.4},
    "position the other way": {"position": lambda mm: 600.0 - mm},
    "position + 40 mm": {"position": lambda mm: mm + 40.0},
    "position at 0": {"position": lambda mm: 0.0 * mm},
    "position stands still": {"position": lambda mm: np.full_like(mm, mm[0])},
    "position not told": {"position": lambda mm: np.full_like(mm, np.nan)},
    "position jumps": {
        "position": lambda mm: mm + np.random.default_rng(0).choice([0.0, 100.0], len(mm), p=[0.9, 0.1])
    },
    "speed x 1.3": {"speed": lambda rpm: 1.3 * rpm},
    "speed at 0": {"speed": lambda rpm: 0.0 * rpm},
    "speed stands still": {"speed": lambda rpm: np.full_like(rpm, rpm[0])},
    "speed not told": {"speed": lambda rpm: np.full_like(rpm, np.nan)},
}
FIRST = ", from the start on"
DRIVES |= {f"{kind}{FIRST}": DRIVES[kind] for kind in ("position the other way", "position + 40 mm")}
HEAD = ("", "um, most", "um, valid", "lost while valid, s", "named after s, median", "worst", "others accused")


@dataclass(frozen=True)
class Found:
    """What becomes of a lie: most that the estimate is off by, ever and while valid, um; for how long it is lost while
    valid, s; when it is named, inf: never; how many others are accused."""

    um: float
    valid_um: float
    lost_s: float
    named_s: float
    accused: int


@lru_cache(maxsize=2)
def _simulated(name: str, machine: int) -> tuple[Run, Recording, Array]:
    """A run, as ticks, and its true elongation."""
    run = simulate(name, machine=machine, seed=SEED)
    good = handed_over.record(run, paper_rig.rig())
    return run, good, np.interp(good.time_s, run.truth.time_s, run.truth.elongation_um)


def _lying(run: Run, good: Recording, kind: str, at_s: float, rig: Rig) -> Recording:
    """The recording with a lie from a time on."""
    if kind in DRIVES:
        return handed_over.record(run, rig, DRIVES[kind], -np.inf if kind.endswith(FIRST) else at_s)
    now, i, readings = good.time_s >= at_s, rig.index("displacement"), good.channels.copy()
    before = readings[~now, i]
    readings[now, i] = LENGTHS[kind](readings[now, i], before[np.isfinite(before)][-1])
    return replace(good, channels=readings)


def valid(recording: Recording, track: Track, rig: Rig) -> Array:
    """At which ticks live sends the estimate as valid, (K,) bool."""
    tests, watch, valid = Alarms(rig), Watch(rig), np.zeros(len(recording), dtype=bool)
    for k, sample in enumerate(recording):
        step = track.step(k, ("",) * len(rig.names))
        tests.step(step)
        if np.isfinite(sample.omega):
            watch.drive(step.time_s)
        watch.tick(sample, step, tests.diverged)
        valid[k] = watch.trust(step.time_s).valid
    return valid


def found(run: str, at_s: float, machine: int, kind: str) -> Found:
    """One lie."""
    rig, (simulated, good, true_um) = paper_rig.rig(), _simulated(run, machine)
    at_s = 0.0 if kind.endswith(FIRST) else at_s
    recording = _lying(simulated, good, kind, at_s, rig)
    track = replay(paper_rig.model(), rig, recording)
    now = (track.time_s >= at_s) & np.isfinite(track.elongation_um)
    error, sent = abs(true_um - track.elongation_um), valid(recording, track, rig) & now
    lost = sent & (error > np.maximum(LOST_SD * track.sigma_um, LOST_UM))
    broken, own = (track.fault > Fault.JUDGED) & now[:, None], np.zeros(len(rig.names), dtype=bool)
    own[rig.index("displacement")] = kind in LENGTHS
    left_out_s, said_s = track.time_s[broken[:, own].any(axis=1)], [s for s, _ in disagreements(recording, rig)]
    said_s += track.time_s[np.flatnonzero(track.shift_mm)].tolist()
    told_s = left_out_s if kind in LENGTHS else said_s
    named_s = min((float(s) - at_s for s in told_s if s >= at_s), default=np.inf)
    most, trusted = (float(np.max(error[some], initial=0.0)) for some in (now, sent))
    return Found(most, trusted, longest(lost) * rig.tick_s, named_s, int(broken[:, ~own].any(axis=0).sum()))


def table() -> str:
    """All lies."""
    return section("Lengths and drives that lie", [HEAD, *_rows()], level=3)


def _rows() -> Iterator[list[str]]:
    kinds, some = (*LENGTHS, *DRIVES), dict[str, list[Found]]()
    for run, at_s in WHEN:
        for machine in MACHINES:
            for kind in kinds:
                some.setdefault(kind, []).append(found(run, at_s, machine, kind))
                say(f"  {kind}, {run}, machine {machine}: {some[kind][-1]}")
    for kind in kinds:
        columns = {each.name: [getattr(one, each.name) for one in some[kind]] for each in fields(Found)}
        named, worst = np.median(columns["named_s"]), max(columns["named_s"])
        off = [f"{max(columns['um']):.2f}", f"{max(columns['valid_um']):.2f}", f"{max(columns['lost_s']):.0f}"]
        yield [kind, *off, f"{named:.0f}", f"{worst:.0f}", str(sum(columns["accused"]))]
