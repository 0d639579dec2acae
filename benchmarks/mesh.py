"""What the reduced mesh costs: the shipped model on its knots against the same effects on 500 cells, open loop."""

from dataclasses import replace

import numpy as np

from benchmarks import paper_rig
from benchmarks.measure import section
from drivers.recordings import read_recording
from estimator.batch.nominal import open_loop
from estimator.inputs.start import read_start
from estimator.network.forcing import Forcing
from estimator.record import Array, Recording
from estimator.rig import Rig

RUNS = ("FS-20", "CS-20", "ES-20", "FS-2.5")
FINE = 500


def readings(recording: Recording, rig: Rig, reduced: bool) -> tuple[Array, int]:
    """What the channels would read along a recording by the model alone, (K, m), and the number of states."""
    start = read_start(recording.sample(0), rig)
    assert start is not None
    forcing = Forcing(paper_rig.model(), rig, start, reduced)
    level = np.full(forcing.place.size, start.level_C)
    return open_loop(forcing, forcing.read(recording), level, recording.ages_s), forcing.place.size


def markdown() -> str:
    """Largest difference at any thermometer and in the elongation, for each run."""
    rig = paper_rig.rig()
    fine, heat = replace(rig, screw=replace(rig.the_screw(), cells=FINE)), rig.is_thermometer
    rows = [["run", "states", "largest difference at a thermometer, K", "in the elongation, um"]]
    for name in RUNS:
        coarse, states = readings(paper_rig.recording(name), rig, reduced=True)
        exact, _ = readings(read_recording(paper_rig.path_of(name), fine), fine, reduced=False)
        apart = np.abs(coarse - exact)
        rows.append([name, str(states), f"{apart[:, heat].max():.3f}", f"{apart[:, ~heat].max():.3f}"])
    return section(f"Mesh: knots against {FINE} cells of the same effects, open loop", rows)
