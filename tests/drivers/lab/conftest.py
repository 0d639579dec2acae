"""A heated rod with the CSVs of its logger, and what other ways to write the same numbers are compared with."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from drivers.recordings import read_recording
from estimator.errors import InputError
from estimator.record import Recording
from estimator.rig import Rig
from estimator.rig_folder.rig_folder import load_rig
from estimator.rig_log import Csv

ROD = """
name = "heated rod"
tick_s = 1.0
[screw]
from_mm = 0
to_mm = 400
outer_mm = 20
[log]
time_column = "t"
[channels]
A = { at_mm = 50, column = "left" }
B = { at_mm = 350, hi = 90 }
[inputs]
heater = { unit = "W", column = "P/kW", scale = 1000, hi = 500 }
ambient = {}
"""
NAMES = ["t", "left", "B", "P/kW", "ambient"]
STEP, ROWS = 5.0, 60
Rows = list[list[str]]


@pytest.fixture
def rod(tmp_path: Path) -> Rig:
    (tmp_path / "rig.toml").write_text(ROD)
    return load_rig(tmp_path)


@pytest.fixture
def rig(rod: Rig) -> Rig:
    """The rod with a tick as long as its rows are apart."""
    return replace(rod, tick_s=STEP)


def rows(time: Callable[[float], str] = "{:g}".format) -> Rows:
    draw = np.random.default_rng(3)
    values = np.round(draw.uniform(15, 45, (ROWS, 2)), 2)
    return [[time(k * STEP), f"{a:.2f}", f"{b:.2f}", "0.125", "21.5"] for k, (a, b) in enumerate(values)]


def write(path: Path, cells: Rows, names: Sequence[str] = NAMES, sep: str = ",", head: str = "", **how: str) -> Path:
    lines = [sep.join(row) for row in [names, *cells]]
    path.write_text(head + "\n".join(lines) + "\n", **how)
    return path


def clock(form: str, start: str = "2026-03-01 12:00:00") -> Callable[[float], str]:
    return lambda s: (datetime.fromisoformat(start) + timedelta(seconds=s)).strftime(form)


def assert_as_plain(path: Path, rig: Rig, *said: str) -> Recording:
    """The recording is that of the plain CSV, and its notes say these things."""
    record = read_recording(path, rig)
    default = replace(rig, log=replace(rig.log, csv=Csv()))
    plain = read_recording(write(path.with_name("plain.csv"), rows()), default)
    np.testing.assert_allclose(record.time_s, plain.time_s, atol=1e-3)
    np.testing.assert_allclose(record.channels, plain.channels, atol=1e-9)
    np.testing.assert_allclose(record.inputs["heater"], plain.inputs["heater"])
    for words in said:
        assert any(words in note for note in record.notes), record.notes
    return record


def complaint(path: Path, rig: Rig) -> str:
    with pytest.raises(InputError) as error:
        read_recording(path, rig)
    assert "\n" not in str(error.value)
    return str(error.value).removeprefix(f"{path}: ")
