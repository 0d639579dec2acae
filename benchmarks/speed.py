"""How long a review takes, reading a log, and the filter as it runs live."""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks import paper_rig
from benchmarks.measure import Job, interleaved, section
from benchmarks.shipped import stepped
from estimator.filter import Filter

ROUNDS = 5
RUN = "FS-20"


def markdown() -> str:
    """Median seconds over interleaved rounds."""
    recording = paper_rig.recording(RUN)
    jobs: dict[str, Job] = {
        "`ballscrew review FS-20.blf --save`, from file to table and .rrd": _review,
        "reading the log into ticks": lambda: paper_rig.recording(RUN),
        "the filter tick by tick, as live": lambda: stepped(Filter(paper_rig.model(), paper_rig.rig()), recording),
    }
    times = interleaved(jobs, ROUNDS)
    rows = [["", "s"], *([name, f"{np.median(each.wall):.2f}"] for name, each in times.items())]
    return section(f"Speed: one recording of {len(recording)} ticks, {recording.frames} frames", rows)


def _review() -> None:
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "ballscrew", "review", str(paper_rig.path_of(RUN)), "--quiet"]
        subprocess.run([*command, "--save", str(Path(folder) / "run.rrd")], check=True)
