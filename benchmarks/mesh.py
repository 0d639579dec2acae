"""What the reduced mesh costs: the shipped model on its knots against the same effects on 500 cells, open loop."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.accuracy import FOLDER
from drivers.recordings import read_recording
from estimator.batch.nominal import open_loop
from estimator.inputs.start import read_start
from estimator.network.forcing import Forcing
from estimator.record import Array
from estimator.rig import Rig
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig

RUNS = ("FS-20", "CS-20", "ES-20", "FS-2.5")
FINE = 500


def readings(path: Path, rig: Rig, reduced: bool) -> tuple[Array, int]:
    """What the channels would read along a recording by the model alone, (K, m), and the number of states."""
    recording = read_recording(path, rig)
    start = read_start(recording.sample(0), rig)
    assert start is not None
    forcing = Forcing(load_model(FOLDER / "model.toml"), rig, start, reduced)
    level = np.full(forcing.place.size, start.level_C)
    return open_loop(forcing, forcing.read(recording), level, recording.ages_s), forcing.place.size


def markdown() -> str:
    """Largest difference at any thermometer and in the elongation, for each run."""
    rig = load_rig(FOLDER)
    assert rig.screw is not None
    fine = replace(rig, screw=replace(rig.screw, cells=FINE))
    at = [rig.index(name) for name in rig.thermometers]
    rows = []
    for name in RUNS:
        path = FOLDER / f"{name}.blf"
        coarse, states = readings(path, rig, reduced=True)
        exact, _ = readings(path, fine, reduced=False)
        apart = np.abs(coarse - exact)
        rows.append(
            f"| {name} | {states} | {apart[:, at].max():.3f} | {apart[:, rig.index('displacement')].max():.3f} |"
        )
    head = "| run | states | largest difference at a thermometer, K | in the elongation, um |\n|---|---|---|---|"
    return "\n".join([f"## Mesh: knots against {FINE} cells of the same effects, open loop", "", head, *rows])
