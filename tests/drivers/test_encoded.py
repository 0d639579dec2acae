"""The rig in software on the bus of another rig: what its own reader reads back is what was measured."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.encoded import Encoded
from drivers.logs.truth import read_truth
from drivers.recordings import read_recording
from drivers.virtual_rig import Run, simulate
from estimator.errors import SetupError
from estimator.rig import Rig, Signal
from estimator.rig_folder.rig_folder import load_rig
from tests.conftest import ballscrew

SEVEN = Path(__file__).parents[2] / "examples" / "seven_channels"
COLUMNS = [1, 3, 4, 5, 7, 11, 14]  # of the rig in software


@pytest.fixture(scope="module")
def seven() -> Rig:
    return load_rig(SEVEN)


@pytest.fixture(scope="module")
def lived() -> Run:
    return simulate("FS-20", seconds=60.0)


@pytest.mark.parametrize("suffix", [".log", ".blf"])
def test_every_signal_arrives_and_the_truth_is_on_the_log_s_clock(seven, lived, tmp_path, suffix):
    path = tmp_path / f"run{suffix}"
    Encoded(lived, seven).write(path)
    record, truth = read_recording(path, seven), read_truth(path)
    assert record.skipped == {}
    np.testing.assert_allclose(record.channels[:, :7], lived.measured.channels[: len(record), COLUMNS], atol=0.011)
    np.testing.assert_allclose(record.inputs["bar"], lived.measured.environment.bar[: len(record)], atol=0.051)
    direct = lived.measured.direct.elongation_um[:20]
    np.testing.assert_allclose(record.inputs["displacement_direct"][:20], direct, atol=0.001)
    read = np.isfinite(record.channels[:, 7])
    held = lived.holds.reading.elongation_um[: read.sum()]
    np.testing.assert_allclose(record.channels[read, 7], held[: read.sum()], atol=0.001)
    assert np.nanmax(record.omega) == pytest.approx(174.5, abs=0.1)
    np.testing.assert_allclose(truth.time_s[: len(record)], record.time_s, atol=2e-4)
    assert list(truth.channels) == list(seven.thermometers)
    np.testing.assert_array_equal(truth.channels["rear"], np.round(lived.truth.rises[:, 11], 5))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"log": {"checksums": ("BoreMotor.Count",)}}, "log.checksums: no frames are made with that"),
        ({"log": {"dbc": None}}, "log.dbc is missing: CAN frames need a DBC file"),
        ({"inputs": {"oil": Signal("Hall.Air")}}, "oil: the simulated rig has no such thing; it has position, "),
        ({"inputs": {"position": Signal("Hall.Bed"), "base": Signal("Hall.Air")}}, "signals that come at different"),
    ],
    ids=lambda each: each if isinstance(each, str) else "",
)
def test_what_cannot_be_sent_is_said_with_its_place(seven, lived, change, said):
    log = replace(seven.log, **change.get("log", {}))
    with pytest.raises(SetupError, match=f"seven_channels/rig.toml: .*{said}"):
        Encoded(lived, replace(seven, log=log, inputs=change.get("inputs", seven.inputs)))


@pytest.mark.parametrize("fresh", ["Growth.New", "Growth.Centre"], ids=["a count", "the reading itself"])
def test_what_tells_a_new_reading_changes_with_each(fresh, lived, tmp_path):
    dbc, rig = (SEVEN / "plant.dbc").read_text(), (SEVEN / "rig.toml").read_text().splitlines()
    dbc = dbc.replace("Growth: 5 Gauge", 'Growth: 6 Gauge\n SG_ New : 40|8@1+ (1,0) [0|255] "" Filter')
    (tmp_path / "plant.dbc").write_text(dbc)
    rig = [line.replace('"Growth.Centre"', f'"Growth.Centre", fresh = "{fresh}"') for line in rig]
    (tmp_path / "rig.toml").write_text("\n".join(line for line in rig if "displacement_direct" not in line))
    path, counted = tmp_path / "run.log", load_rig(tmp_path)
    Encoded(lived, counted).write(path)
    read = np.isfinite(read_recording(path, counted).channels[:, counted.index("displacement")])
    assert read.sum() == len(lived.holds.frozen_s) > 3


@pytest.mark.parametrize("tick_s", [1.0, 2.0])
def test_ticks_that_are_not_as_far_apart_as_the_rig_says_are_told(tick_s, seven, lived, tmp_path):
    path = tmp_path / "run.log"
    Encoded(lived, seven).write(path)
    notes = read_recording(path, replace(seven, tick_s=tick_s)).notes
    told = "ticks come each 1 s, and each counts as 2 s; in rig.toml say tick_s = 1"
    assert [note for note in notes if "ticks come" in note] == [told] * (tick_s == 2.0)


def test_a_thermometer_where_the_simulated_screw_has_none_is_said(seven, lived):
    channels = {**seven.channels, "left": replace(seven.channels["left"], at_mm=300.0)}
    with pytest.raises(SetupError, match=r"left: at_mm = 300: the simulated screw has its thermometers at 0, 72.5, "):
        Encoded(lived, replace(seven, channels=channels))


def test_the_command_writes_the_recording_of_a_rig_folder(tmp_path):
    words = ("simulate", "FS-20", "--seconds", "30", "-o")
    paper, copied = SEVEN.parents[1] / "recordings", tmp_path / "copied"
    copied.mkdir()
    shutil.copy(paper / "rig.toml", copied)
    shutil.copy(SEVEN.parents[1] / "drivers" / "rig.dbc", copied)
    for rig in (SEVEN, paper, copied):
        out = tmp_path / f"{rig.name}.blf"
        assert ballscrew(*words, out, "--rig", rig)[0] == 0
        assert len(read_recording(out, load_rig(rig))) >= 30
