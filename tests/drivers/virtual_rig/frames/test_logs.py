"""What the virtual rig writes is what is read: two roads that share no code."""

from pathlib import Path

import numpy as np
import pytest

from drivers.logs.truth import read_truth
from drivers.recordings import read_recording
from drivers.virtual_rig import simulate
from drivers.virtual_rig.frames.recording import write
from tests.drivers.decode.test_ticks import RIG, assert_same, streamed


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(simulate("FS-20", seconds=240), tmp_path_factory.mktemp("rig") / "run.log")


def test_nothing_of_a_sound_log_is_skipped(log: Path) -> None:
    record = read_recording(log, RIG)
    assert len(record) == 240
    assert set(record.skipped) <= {"after the last whole tick", "held since before the log displacement_direct"}
    assert record.notes == ()
    assert np.isfinite(record.channels[:, :15]).all()
    assert np.isfinite(record.omega).all()
    for name in ("position", "speed", "current", "ambient", "base", "nut", "probe", "bar", "board"):
        assert np.isfinite(record.inputs[name]).all(), name
    np.testing.assert_allclose(np.sum(record.coverage, axis=1) * RIG.screw.length, 0.175, rtol=1e-6)


def test_readings_follow_the_truth(log: Path) -> None:
    record, truth = read_recording(log, RIG), read_truth(log)
    assert truth is not None
    rise = record.channels[:, 6] - record.channels[:20, 6].mean()
    assert np.abs(rise - np.interp(record.time_s, truth.time_s, truth.channels["T07"])).max() < 0.5
    assert record.omega.max() == pytest.approx(1667 * 2 * np.pi / 60, rel=0.02)
    length = record.channels[:, 15]
    assert 20 < np.isfinite(length).sum() < 240


def test_live_and_review_agree(log: Path) -> None:
    assert_same(read_recording(log, RIG), streamed(log)[0])
