"""The drift of an axis: heatings and coolings, and the ranges in them."""

from dataclasses import replace

import numpy as np
import pytest

from ballscrew.page.iso230.drift import Drift, drift, spells
from ballscrew.page.iso230.drift_section import as_json, section, table
from ballscrew.page.iso230.positions import ends_and_middle, positions
from drivers.logs.truth import Truth
from estimator.accuracy.review import review
from estimator.errors import SetupError
from estimator.record import Recording

TURNING = 50.0


def recording(*stretches: tuple[float, int]) -> Recording:
    """Speeds, each for so many minutes; a tick each 30 s."""
    omega = np.concatenate([np.full(2 * count, speed) for speed, count in stretches])
    K = len(omega)
    nothing = np.zeros((K, 0))
    return Recording("run", 30.0 * np.arange(K), nothing, nothing, {"position": np.zeros(K)}, omega, nothing)


def test_short_rests_between_drives_are_part_of_the_heating():
    run = recording((0, 3), (TURNING, 10), (0, 4), (TURNING, 10), (0, 30), (TURNING, 5), (0, 2))
    found = spells(run)
    assert [one.name for one in found] == ["heating 1", "cooling 1", "heating 2", "cooling 2"]
    assert [(one.first, one.last) for one in found] == [(5, 53), (53, 113), (113, 123), (123, 127)]  # touch each other
    assert spells(recording((0, 30))) == []


def drifting(sd: float, true: bool) -> Drift:
    """40 um up within 100 min at P2, half of it at P1, back to 10 um within 100 min; compensation lags by 0.1 um."""
    run = recording((TURNING, 100), (0, 100))
    far = np.concatenate([np.linspace(0, 40, 200), np.linspace(40, 10, 200)])
    whole = np.column_stack([far / 2, far])
    whole[:3] = np.nan
    left = np.where(run.omega[:, None] > 0, 0.1, 0.0) + np.zeros((1, 2))
    return Drift(run, np.array([20.0, 380.0]), whole, left, np.full((400, 2), sd), true, spells(run))


def test_ranges_of_the_first_hour_and_of_all():
    one = drifting(0.0, true=True)
    heating, cooling = (one.ranges(spell)[1] for spell in one.spells)
    assert heating.first_hour_um == pytest.approx(40 * (120 - 3) / 199)
    assert heating.whole_um == pytest.approx(40 * (199 - 3) / 199)
    assert heating.end_um == 40
    assert (cooling.whole_um, cooling.end_um, cooling.two_sd_um) == (30, 10, 0)
    assert (heating.left_whole_um, cooling.left_whole_um, cooling.left_end_um) == (0, pytest.approx(0.1), 0)
    head, *rows = table(one)
    assert head == ["um", "P1 at 20 mm", "compensated", "P2 at 380 mm", "compensated"]
    assert [row[0] for row in rows][:2] == ["heating 1: range in its first 60 min", "heating 1: range in 1 h 39 min"]
    assert rows[-1] == ["cooling 1: deviation at its end", "+5.00", "+0.00", "+10.00", "+0.00"]


def test_of_an_estimate_two_sd_count_on_both_sides():
    one = drifting(0.5, true=False)
    cooling = one.ranges(one.spells[1])[0]
    assert cooling.left_whole_um == pytest.approx(0.1 + 2 * 2 * 0.5)
    assert table(one)[-1] == [
        "cooling 1: deviation at its end",
        "+5.00 +- 1.00",
        "+- 1.00",
        "+10.00 +- 1.00",
        "+- 1.00",
    ]
    assert as_json([one])[0]["by"] == "estimate"
    assert "estimate, ± 2 sd;" in section([one]).html()


def test_a_recording_without_a_drive_says_so():
    still = replace(drifting(0.0, true=True), spells=[])
    assert "no drive in it" in section([still]).html()
    unknown = replace(drifting(0.0, true=True), whole_um=np.full((400, 2), np.nan))
    assert "the error at the table is not known" in section([unknown]).html()


@pytest.fixture(scope="module")
def reviewed(rig, shipped, driven, live):
    lived = live(shipped, rig, driven(rig, 90, (20, 60), stroke=(0.0, 400.0)), seed=1)
    return review(lived.recording, rig, shipped, table_mm=[10.0, 200.0, 390.0, *np.linspace(0, 400, 5)])


def test_compensated_is_the_truth_less_what_was_published_a_tick_before(reviewed):
    est, time_s = reviewed.table.error_um, reviewed.recording.time_s
    at_mm = np.linspace(0, 400, 5)
    truth = Truth(time_s, time_s, {}, {at: est[:, 3 + i] + 0.25 for i, at in enumerate(at_mm)})
    found = drift(reviewed, truth, [10.0, 390.0])
    assert found.true
    np.testing.assert_allclose(found.whole_um, est[:, [0, 2]] + 0.25, atol=0.02)
    np.testing.assert_allclose(found.left_um[1:], (found.whole_um[1:] - est[:-1, [0, 2]]))
    assert np.isnan(found.left_um[0]).all()
    assert (found.sd_um == 0).all()


@pytest.mark.parametrize("truth", [None, Truth(np.arange(2.0), np.zeros(2), {}, {})])
def test_without_a_truth_at_the_table_the_estimate_stands_with_its_sd(reviewed, truth):
    found = drift(reviewed, truth, [10.0, 390.0])
    assert not found.true
    np.testing.assert_array_equal(found.whole_um, reviewed.table.error_um[:, [0, 2]])
    np.testing.assert_array_equal(found.sd_um, reviewed.table.sd_um[:, [0, 2]])
    assert [spell.heats for spell in found.spells] == [True, False]


def test_positions_default_to_the_stroke_s_ends_and_middle():
    run = recording((TURNING, 2))
    assert ends_and_middle(run) == []
    run.inputs["position"][:] = [0.2, 399.7, np.nan, 150.0]
    assert ends_and_middle(run) == [0.0, 200.0, 400.0]
    assert ends_and_middle(replace(run, inputs={})) == []


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("20", "two or three different positions are needed"),
        ("20,20", "two or three different positions"),
        ("1,2,3,4", "two or three different positions"),
        ("20;380", "write two or three positions of the table in mm, like 20,200,380"),
        ("20,nan", "nut's centre would be at nan mm"),
        ("20,900", "--at 900: the nut's centre would be at -226.5 mm, beside the screw (-50 ... 1030 mm)"),
    ],
)
def test_positions_that_cannot_be_are_refused(text, said, rig):
    with pytest.raises(SetupError) as error:
        positions(text, rig)
    assert said in str(error.value)


def test_positions_in_any_order(rig):
    assert positions("380, 20", rig) == [20.0, 380.0]
