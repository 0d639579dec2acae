"""What a recording does not have for long."""

from pathlib import Path

import numpy as np
import pytest

from drivers.frames import Tally
from drivers.silences import silences
from estimator.record import Recording
from estimator.rig import Rig
from estimator.rig_folder.rig_folder import load_rig

ROWS = 2000


@pytest.fixture
def rig() -> Rig:
    return load_rig(Path(__file__).parents[2] / "recordings")


def recording(rig: Rig) -> Recording:
    channels = np.full((ROWS, len(rig.names)), 20.0)
    inputs = {name: np.full(ROWS, 20.0) for name in rig.inputs}
    steady = np.zeros(ROWS), np.zeros((ROWS, rig.screw.cells))
    return Recording("a", np.arange(ROWS, dtype=float), channels, np.zeros_like(channels), inputs, *steady)


def notes(rig: Rig, run: Recording) -> list[str]:
    tally = Tally()
    silences(run, rig, tally)
    return tally.notes


def test_thermometers_inputs_and_drive_that_are_silent_for_long(rig: Rig) -> None:
    run = recording(rig)
    run.channels[600:1001, [2, 3]] = np.nan
    run.inputs["position"][:500] = run.inputs["speed"][:500] = np.nan
    run.inputs["ambient"][1500:] = np.nan
    assert notes(rig, run) == [
        "no reading of position, speed for 500 s, from 0 s on",
        "no reading of T03, T04 for 402 s, from 599 s on",
        "no reading of ambient for 500 s, from 1499 s on",
    ]


def test_short_gaps_slow_signals_and_what_is_read_in_some_states_only_are_no_silence(rig: Rig) -> None:
    run = recording(rig)
    run.channels[600:800, 2] = np.nan
    run.channels[np.arange(ROWS) % 400 > 0, 3] = np.nan
    run.channels[300:1500, rig.names.index("displacement")] = np.nan
    run.channels[:, 4] = np.nan
    assert notes(rig, run) == []
