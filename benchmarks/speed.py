"""How long a review takes, and reading a log beside what one would write with python-can and cantools alone."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import can
import cantools
import numpy as np

from benchmarks import paper_rig
from benchmarks.measure import Job, interleaved, over, section
from benchmarks.shipped import stepped
from drivers.decode.dbc import find_dbc
from estimator.filter import Filter

ROUNDS = 5
RUN = "FS-20"


def markdown() -> str:
    """Median seconds over interleaved rounds, and ratios from the same rounds."""
    recording = paper_rig.recording(RUN)
    jobs: dict[str, Job] = {
        "`ballscrew review FS-20.blf --save`, from file to table and .rrd": _review,
        "reading the log into ticks": lambda: paper_rig.recording(RUN),
        "python-can's reader and cantools' decode of each frame": _by_hand,
        "the filter tick by tick, as live": lambda: stepped(Filter(paper_rig.model(), paper_rig.rig()), recording),
    }
    times = interleaved(jobs, ROUNDS)
    rows = [["", "s"], *([name, f"{np.median(each.wall):.2f}"] for name, each in times.items())]
    _, ours, by_hand, _ = times.values()
    ratio = over(ours, by_hand, "wall")
    rows.append([f"reading, ours / by hand, median ratio of {ROUNDS} rounds", f"{ratio:.2f}"])
    return section(f"Speed: one recording of {len(recording)} ticks, {recording.frames} frames", rows)


def _review() -> None:
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "ballscrew", "review", str(paper_rig.path_of(RUN)), "--quiet"]
        subprocess.run([*command, "--save", str(Path(folder) / "run.rrd")], check=True)


def _by_hand() -> int:
    """Every frame decoded, none yet condensed into ticks."""
    database = cantools.database.load_file(find_dbc("rig.dbc", paper_rig.FOLDER))
    frames = 0
    with can.LogReader(paper_rig.path_of(RUN)) as reader:
        for message in reader:
            database.decode_message(message.arbitration_id, message.data)
            frames += 1
    return frames
