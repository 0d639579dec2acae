"""How long a review takes, and reading a log beside what one would write with python-can and cantools alone."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import can
import cantools
import numpy as np

from benchmarks.accuracy import FOLDER
from benchmarks.shipped import stepped
from drivers.decode.dbc import find_dbc
from drivers.recordings import read_recording
from estimator.filter import Filter
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig

ROUNDS = 5
RUN = FOLDER / "FS-20.blf"


def markdown() -> str:
    """Median seconds over interleaved rounds, and ratios from the same rounds."""
    rig = load_rig(FOLDER)
    model = load_model(FOLDER / "model.toml")
    recording = read_recording(RUN, rig)
    jobs: dict[str, Callable[[], object]] = {
        "`ballscrew review FS-20.blf --save`, from file to table and .rrd": _review,
        "reading the log into ticks": lambda: read_recording(RUN, rig),
        "python-can's reader and cantools' decode of each frame": _by_hand,
        "the filter tick by tick, as live": lambda: stepped(Filter(model, rig), recording),
    }
    seconds = {name: [] for name in jobs}  # type: dict[str, list[float]]
    for _ in range(ROUNDS):
        for name, job in jobs.items():
            began = time.perf_counter()
            job()
            seconds[name].append(time.perf_counter() - began)
    names = list(jobs)
    ratio = np.median(np.array(seconds[names[1]]) / np.array(seconds[names[2]]))
    rows = [f"| {name} | {np.median(values):.2f} |" for name, values in seconds.items()]
    rows.append(f"| reading, ours / by hand, median ratio of {ROUNDS} rounds | {ratio:.2f} |")
    title = f"## Speed: one recording of {len(recording)} ticks, {recording.frames} frames"
    return "\n".join([title, "", "| | s |\n|---|---|", *rows])


def _review() -> None:
    with tempfile.TemporaryDirectory() as folder:
        save = ["--quiet", "--save", str(Path(folder) / "run.rrd")]
        subprocess.run([sys.executable, "-m", "ballscrew", "review", str(RUN), *save], check=True)


def _by_hand() -> int:
    """Every frame decoded, none yet condensed into ticks."""
    database = cantools.database.load_file(find_dbc("rig.dbc", FOLDER))
    frames = 0
    with can.LogReader(RUN) as reader:
        for message in reader:
            database.decode_message(message.arbitration_id, message.data)
            frames += 1
    return frames
