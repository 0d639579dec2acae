"""How time and memory grow with the length of a recording and with the number of states."""

from __future__ import annotations

import json
import re
import resource
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks import paper_rig
from benchmarks.measure import Row, alone, interleaved, say, table
from benchmarks.problem import make
from benchmarks.shipped import RUN, trial_of
from estimator.batch import batch
from estimator.batch.system import System

HOURS = (1, 8, 24)
STATES = (12, 22, 36, 48, 60)
STEPS = 7200
ROUNDS = 5
REPEATS = 2
LINEAR = FLAT = 1.10
JOBS = {"log-likelihood": batch.loglike, "smoother": batch.smoothed, "gradient": batch.score}
KEPT = ("smoother", "gradient")  # jobs whose result grows with the ticks
PER_TICK = ("y", "regime", "b", "grown", "R", "muted")


def tiled(system: System, ticks: int) -> System:
    """The system's ticks over and over."""
    at = np.arange(ticks) % len(system.y)
    return replace(system, **{name: getattr(system, name)[at] for name in PER_TICK})


def markdown() -> str:
    """Hours of recording in processes of their own, then states."""
    return _hours() + "\n" + _states()


def _hours() -> str:
    trial, _ = trial_of(RUN)
    system = trial.pose(paper_rig.model()).system
    ticks = {hours: round(hours * 3600 / trial.rig.tick_s) for hours in HOURS}
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for hours in HOURS:
            (at := Path(folder) / str(hours)).mkdir()
            for name, value in vars(tiled(system, ticks[hours])).items():
                np.save(at / name, value)
        for job in JOBS:
            rows += _growth(job, _in_turn(job, Path(folder), ticks))
    title = f"Engine: growth with hours, {RUN} repeated, {len(system.x0)} states"
    return table(title, rows, [
        f"CPU time a tick, best of {ROUNDS} rounds in turn, each the best of {REPEATS}; memory is what the process "
        "grew by at its peak, less the result itself. "
        f"What fits into {batch.BUDGET / 1e6:.0f} MB on the way back is filtered once, the rest twice."
    ])  # fmt: skip


def _in_turn(job: str, folder: Path, ticks: dict[int, int]) -> dict[int, tuple[float, float]]:
    """us a tick and MB by hours, every length once a round: a machine may be slower for minutes."""
    rounds: dict[int, list[dict[str, float]]] = {hours: [] for hours in ticks}
    for done in range(ROUNDS):
        say(f"  {job}, round {done + 1} of {ROUNDS}")
        for hours in ticks:
            rounds[hours].append(json.loads(alone("growth", str(folder / str(hours)), job, what="timed")))
    return {
        hours: (1e6 * min(m["seconds"] for m in some) / ticks[hours], max(m["bytes"] for m in some) / 1e6)
        for hours, some in rounds.items()
    }


def _growth(job: str, by_hours: dict[int, tuple[float, float]]) -> list[Row]:
    first, middle, last = HOURS
    rows = [Row(f"{job}, {h} h", f"{us:.1f} us, {size:.0f} MB") for h, (us, size) in by_hours.items()]
    slower = [by_hours[last][0] / by_hours[h][0] for h in (middle, first)]
    rows.append(Row(f"{job}, time a tick, {last} h / {middle} h", f"{slower[0]:.2f}", slower[0], LINEAR))
    rows.append(Row(f"{job}, time a tick, {last} h / {first} h", f"{slower[1]:.2f}"))
    if job in KEPT:
        more = by_hours[last][1] / by_hours[middle][1]
        rows.append(Row(f"{job}, memory, {last} h / {middle} h", f"{more:.2f}", more, FLAT))
    return rows


def _states() -> str:
    problems = {n: make(n, STEPS).system() for n in STATES}
    jobs = {f"{job} {n}": lambda s=s, run=run: run(s) for n, s in problems.items() for job, run in JOBS.items()}
    times = interleaved(jobs, 5)
    rows = []
    for n in STATES:
        each = [1e6 * np.median(times[f"{job} {n}"].cpu) / STEPS for job in JOBS]
        rows.append(Row(f"{n} states", ", ".join(f"{job} {us:.1f} us" for job, us in zip(JOBS, each))))
    return table(f"Engine: growth with states, {STEPS} steps", rows, ["CPU time a step."])


def timed(folder: str, name: str) -> str:
    """Time one job on the system kept there, and say how much memory it took beside data and result, as JSON."""
    system, job = System(**{file.stem: np.load(file) for file in Path(folder).iterdir()}), JOBS[name]
    job(tiled(system, 60))  # compiled, loaded
    before, seconds = _peak_from_now(), []
    for _ in range(REPEATS):
        began = time.process_time()
        result = job(system)
        seconds.append(time.process_time() - began)
        size = sum(a.nbytes for a in vars(result).values() if isinstance(a, np.ndarray)) if name in KEPT else 0
        del result
    return json.dumps({"seconds": min(seconds), "bytes": _peak() - before - size})


def _peak_from_now() -> int:
    """The peak, forgotten first where Linux lets one: what loading took at times would hide what comes."""
    forget = Path("/proc/self/clear_refs")
    if forget.exists():
        forget.write_text("5")
    return _peak()


def _peak() -> int:
    """Most memory the process held, bytes. Linux counts its parent's into ru_maxrss, so ask for its own there."""
    status = Path("/proc/self/status")
    if status.exists():
        return 1024 * int(re.search(r"VmHWM:\s+(\d+)", status.read_text())[1])
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
