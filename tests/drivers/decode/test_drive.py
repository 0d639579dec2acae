"""The drive in ticks: mean speed, and the exact cover of a moving nut."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from drivers.decode import drive
from drivers.decode.drive import DriveCondenser, covered
from drivers.frames import Tally
from drivers.recordings import read_recording
from estimator.screw import Screw
from tests import log_fake
from tests.conftest import RIG

SCREW = Screw(from_mm=0, to_mm=980, outer_mm=40, bore_mm=17, cells=49)
WAY = st.tuples(st.floats(-100, 1100), st.one_of(st.just(0.0), st.floats(-300, 300)), st.floats(0.01, 5))


@given(ways=st.lists(WAY, min_size=1, max_size=6), length=st.floats(5, 400))
def test_cover_is_the_mean_over_the_way(ways: list, length: float) -> None:
    begin, step, weight = (np.array(column) for column in zip(*ways, strict=True))
    row = np.zeros(len(ways), np.intp)
    cover = covered(SCREW, length, (begin, begin + step), weight, row, 2)
    instants = (np.arange(2000) + 0.5) / 2000
    boxes = [
        SCREW.overlap(b + s * instants - length / 2, b + s * instants + length / 2).mean(axis=0)
        for b, s in zip(begin, step, strict=True)
    ]
    np.testing.assert_allclose(cover[0], np.average(boxes, axis=0, weights=weight), atol=2e-5)
    assert (cover[1] == 0).all()


def test_cover_is_the_same_however_many_ticks_are_worked_out_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    row = np.array([0, 0, 2, 3, 3, 4])
    way = np.linspace(0.0, 500.0, 6), np.linspace(100.0, 900.0, 6)
    whole = covered(SCREW, 100.0, way, np.arange(1.0, 7.0), row, 6)
    monkeypatch.setattr(drive, "AT_ONCE", 2)
    np.testing.assert_array_equal(covered(SCREW, 100.0, way, np.arange(1.0, 7.0), row, 6), whole)
    assert whole[[0, 2, 3, 4]].any(axis=1).all()


def stroke(tmp_path: Path, hertz: int):
    return read_recording(log_fake.write(tmp_path / f"{hertz}.log", log_fake.log(17, hertz, (2, 14))), RIG)


@pytest.mark.parametrize(("hertz", "error"), [(20, 0.006), (100, 0.0005)])
def test_a_tick_is_what_the_table_did(tmp_path: Path, hertz: int, error: float) -> None:
    """At 20 Hz the nut jumps four cells between frames; cover and speed are those of the true motion all the same."""
    record = stroke(tmp_path, hertz)
    for k in range(4, 13):
        # a tick reaches from its predecessor's last drive frame to its own
        s = k - 1 / hertz + (np.arange(4000) + 0.5) / 4000
        place, rpm = np.transpose([log_fake.position(x) for x in s])
        centre = RIG.nut.centre(place)
        box = RIG.screw.overlap(centre - RIG.nut.length_mm / 2, centre + RIG.nut.length_mm / 2)
        np.testing.assert_allclose(record.coverage[k], np.average(box, axis=0, weights=np.abs(rpm)), atol=error)
        np.testing.assert_allclose(record.stay[k], box.mean(axis=0), atol=2 * error)  # it turns between frames
        assert record.omega[k] == pytest.approx(np.abs(rpm).mean() * 2 * np.pi / 60, rel=error)
        assert record.unevenness[k] == pytest.approx((rpm**2).mean() / np.abs(rpm).mean() ** 2, rel=2 * error)
    np.testing.assert_allclose(np.sum(record.coverage, axis=1) * RIG.screw.length, 0.175, rtol=1e-9)
    np.testing.assert_array_equal(record.omega[[0, 1, 15, 16]], 0)
    np.testing.assert_array_equal(record.unevenness[[0, 1, 15, 16]], 1)


def test_a_silent_drive_is_held_two_ticks(tmp_path: Path) -> None:
    rows = [r for r in log_fake.log(12, 20, (3, 12)) if r.id != 0x230 or not 5 <= r.time - log_fake.START < 9.5]
    record = read_recording(log_fake.write(tmp_path / "a.log", rows), RIG)
    np.testing.assert_array_equal(np.isnan(record.omega), [k in (7, 8) for k in range(12)])
    np.testing.assert_array_equal(np.isnan(record.coverage).all(axis=1), [k in (7, 8) for k in range(12)])
    assert record.omega[5] == record.omega[6] > 0
    assert record.skipped["tick without drive"] == 2
    assert np.isnan(record.inputs["position"][5])


def test_a_rig_without_drive_or_screw(tmp_path: Path) -> None:
    path = log_fake.write(tmp_path / "a.log", log_fake.log(3))
    inputs = {name: rule for name, rule in RIG.inputs.items() if name not in ("position", "speed")}
    record = read_recording(path, replace(RIG, inputs=inputs, screw=None, nut=None))
    assert record.coverage.shape == (3, 0)
    assert (record.omega == 0).all()
    assert (read_recording(path, replace(RIG, nut=None)).coverage == np.zeros((3, RIG.screw.cells))).all()


def test_a_wait_between_strokes_is_idle_and_a_rest_is_not() -> None:
    """0.4 s of each second the screw stands at the end of its stroke; then it stands for good."""
    now = np.arange(0.0, 3.005, 0.01)
    turns = (now % 1.0 < 0.595) & (now < 2.0)
    speed, row = np.where(turns, 100.0, 0.0), np.minimum(np.ceil(now - 1e-9).astype(int), 3)
    found = DriveCondenser(RIG, Tally(), 2).rows(now, np.full(len(now), 200.0), speed, row, 4)
    np.testing.assert_allclose(found.idle[1:3], 0.4, atol=0.021)
    assert found.idle[3] == 0.0
