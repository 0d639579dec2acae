"""Timing in interleaved rounds, and rows that say what was measured, what it must be, and whether it is so."""

import os
import platform
import re
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from ballscrew.report import sections
from estimator.record import Array

ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "JAX_PLATFORMS": "cpu",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
}

Job = Callable[[], object]
Result = TypeVar("Result")


@dataclass(frozen=True)
class Times:
    """Seconds of one job in each round: of the processor, and on the clock."""

    cpu: Array
    wall: Array

    def per(self, steps: int) -> str:
        """Medians per step."""
        return f"{1e6 * np.median(self.cpu) / steps:.1f} us, {1e6 * np.median(self.wall) / steps:.1f} on the clock"


def over(a: Times, b: Times, by: str = "cpu") -> float:
    """Median of the ratios a / b of each round."""
    return float(np.median(getattr(a, by) / getattr(b, by)))


def timed(job: Callable[[], Result]) -> tuple[Result, float, float]:
    """What a job returns, and its seconds: of the processor, and on the clock."""
    cpu, wall = time.process_time(), time.perf_counter()
    result = job()
    return result, time.process_time() - cpu, time.perf_counter() - wall


def interleaved(jobs: Mapping[str, Job], rounds: int) -> dict[str, Times]:
    """Every job once a round, each round begun by another; after one round that does not count."""
    names = list(jobs)
    seconds = {name: np.empty((rounds, 2)) for name in names}
    for done in range(-1, rounds):
        say(f"  round {done + 1} of {rounds}")
        first = done % len(names)
        for name in names[first:] + names[:first]:
            _, *taken = timed(jobs[name])
            if done >= 0:
                seconds[name][done] = taken
    return {name: Times(*both.T) for name, both in seconds.items()}


@dataclass(frozen=True)
class Row:
    """One figure as it is printed; with a limit, what it must not exceed, or (`least`) not fall short of.

    most  which it must not exceed either, where the limit is the least
    """

    what: str
    text: str
    value: float = float("nan")
    limit: float | None = None
    least: bool = False
    most: float = float("inf")

    @property
    def met(self) -> bool:
        """Whether it is as it must be."""
        return self.limit is None or (self.limit <= self.value <= self.most if self.least else self.value <= self.limit)

    @property
    def cells(self) -> list[str]:
        """What it is, how large, how large it must be, and whether it is so."""
        if self.limit is None:
            return [self.what, self.text, "", ""]
        must = f"{'>=' if self.least else '<='} {self.limit:g}"
        if self.most < float("inf"):
            must = f"{self.limit:g} .. {self.most:g}"
        return [self.what, self.text, must, "yes" if self.met else "**no**"]


def ratio(what: str, a: Times, b: Times, limit: float | None = None, by: str = "cpu") -> Row:
    """A row of a / b, by CPU time or by the clock (`wall`), which the limit is for; the other in brackets."""
    figures = {"cpu": over(a, b), "wall": over(a, b, "wall")}
    other = "wall" if by == "cpu" else "cpu"
    names = {"cpu": "CPU", "wall": "clock"}
    text = f"{figures[by]:.3f} by {names[by]} ({figures[other]:.3f} by {names[other]})"
    return Row(what, text, figures[by], limit)


def table(title: str, rows: Sequence[Row], says: Sequence[str] = ()) -> str:
    """A section: what was done, then the rows."""
    return section(title, [["", "measured", "must be", "is so"], *(row.cells for row in rows)], says)


def section(title: str, rows: Sequence[Sequence[str]], says: Sequence[str] = (), level: int = 2) -> str:
    """A heading, sentences, and a table, its head first."""
    return "\n".join([f"{'#' * level} {title}", "", *(f"{said}\n" for said in says), *sections.table(rows), ""])


def machine() -> str:
    """What this ran on, and how busy it was."""
    model = platform.processor() or platform.machine()
    if os.path.exists("/proc/cpuinfo"):
        with open("/proc/cpuinfo") as lines:
            model = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), model)
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return f"{model} ({platform.machine()}, {os.cpu_count()} cores{load}), Python {platform.python_version()}"


def commit() -> str:
    """What was measured: the commit, and whether anything but the results has been changed since."""
    git = ["git", "-C", str(Path(__file__).parents[1])]
    done = subprocess.run([*git, "rev-parse", "--short", "HEAD"], capture_output=True, text=True)
    if done.returncode:
        return "no commit"
    changed = subprocess.run([*git, "diff", "--quiet", "HEAD", "--", ".", ":(exclude)benchmarks/RESULTS.md"]).returncode
    return f"commit {done.stdout.strip()}{' and changes' if changed else ''}"


def alone(study: str, *words: str, what: str = "markdown") -> str:
    """What a function of a study returns, in a process of its own that computes in one thread."""
    code = f"import sys; from benchmarks.{study} import {what} as run; print(run(*sys.argv[1:]))"
    command = [sys.executable, "-c", code, *words]
    done = subprocess.run(command, env={**os.environ, **ONE_THREAD}, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise SystemExit(done.returncode)
    return done.stdout


def numbers(word: str) -> range:
    """`3` or `1-4` as numbers; none where a word is no number."""
    found = re.fullmatch(r"(\d+)(?:-(\d+))?", word)
    return range(int(found[1]), int(found[2] or found[1]) + 1) if found else range(0)


def say(words: str) -> None:
    """Progress."""
    print(words, file=sys.stderr, flush=True)
