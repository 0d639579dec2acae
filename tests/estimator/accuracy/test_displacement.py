"""The paper's five corrections of the displacement, each on a series made by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from estimator.accuracy import displacement
from estimator.inputs.phase import phases
from estimator.model import model_of

NAN = np.nan


@pytest.fixture
def run(rig, driven):
    """30 s: rest to 4 s, a drive from 4 to 24 s, rest. Nothing read yet."""
    recording = driven(rig, 30, (4, 24))
    recording.inputs["displacement_direct"][:] = NAN
    return recording


def held(run, readings: dict[int, float]) -> None:
    """Readings held at the stroke centre by second, as the half sum of both probes."""
    for second, um in readings.items():
        run.channels[second - 1, 15] = um


def direct(run, readings: dict[int, float]) -> None:
    for second, um in readings.items():
        run.inputs["displacement_direct"][second - 1] = um


def joined(run, rig, full) -> dict[int, float]:
    """What came out, by second."""
    out = displacement.joined(run, rig, full).um
    return {k + 1: float(out[k]) for k in np.flatnonzero(np.isfinite(out))}


def test_the_half_stroke_before_the_first_held_value(run, rig, full):
    """Strokes of 4 s with centres at 6, 10, 14 ...: at the first centre half of the next stroke's growth is reached."""
    held(run, {6: 100.0, 10: 106.0, 14: 110.0, 18: 113.0, 22: 115.0})
    assert joined(run, rig, full) == pytest.approx({6: 3.0, 10: 9.0, 14: 13.0, 18: 16.0, 22: 18.0})


@pytest.mark.parametrize(("first", "share"), [(5, 0.25), (7, 0.75), (12, 1.0)])
def test_a_first_value_that_comes_early_or_late_counts_by_its_time(first, share, run, rig, full):
    """A share of the next stroke's growth, but never more than the whole."""
    held(run, {first: 100.0, first + 4: 108.0, 22: 110.0})
    assert joined(run, rig, full)[first] == pytest.approx(8.0 * share)


def test_the_half_stroke_after_the_last_and_the_join_at_the_stop(run, rig, full):
    """From the last centre (22 s) to the stop (24 s) half of the last stroke's growth; direct readings join there."""
    held(run, {6: 100.0, 10: 106.0, 14: 110.0, 18: 113.0, 22: 115.0})
    direct(run, {25: -7.0, 27: -8.0, 30: -9.5})  # -6.5 at the stop
    out = joined(run, rig, full)
    assert {t: out[t] for t in (25, 27, 30)} == pytest.approx({25: 18.5, 27: 17.5, 30: 16.0})


def test_the_scatter_of_one_direct_reading_does_not_stay(run, rig, full):
    held(run, {6: 100.0, 10: 100.0, 22: 100.0})
    direct(run, {25: 5.3, 26: 5.0, 27: 5.0, 28: 4.9, 29: 5.0, 30: 5.0})
    out = joined(run, rig, full)
    assert out[25] == pytest.approx(0.1, abs=0.06)
    assert out[30] == pytest.approx(-0.2, abs=0.06)


def test_what_is_read_as_the_screw_begins_to_turn_is_left_out(run, rig, full):
    """The last tick at rest: its reading may have been taken after the start, where the disc wobbles."""
    direct(run, {1: 5.0, 2: 5.0, 3: 5.0, 4: 6.4})
    held(run, {6: 100.0, 10: 100.0})
    assert joined(run, rig, full) == pytest.approx({1: 0.0, 2: 0.0, 3: 0.0, 6: 0.0, 10: 0.0})


def test_a_reading_counts_from_when_it_was_taken(run, rig, full):
    """The same readings, reported half a second late: the half strokes keep their length."""
    held(run, {7: 100.0, 11: 106.0, 15: 110.0, 19: 113.0, 23: 115.0})
    run.ages_s[:, 15] = 1.0
    direct(run, {25: 0.0})
    out = joined(run, rig, full)
    assert (out[7], out[23], out[25]) == pytest.approx((3.0, 18.0, 19.0))


def test_at_rest_the_direct_reading_counts_from_its_first_value(run, rig, full):
    direct(run, {1: 5.0, 2: 5.1, 3: 5.2})
    held(run, {6: 100.0, 10: 106.0, 22: 112.0})
    out = joined(run, rig, full)
    assert (out[1], out[2], out[3]) == pytest.approx((0.0, 0.1, 0.2))
    assert out[6] == pytest.approx(0.2 + 3.0)


def test_held_values_at_rest_and_direct_ones_while_driving_are_not_used(run, rig, full):
    held(run, {2: 50.0, 6: 100.0, 10: 106.0, 28: 70.0})
    direct(run, {8: 33.0})
    assert set(joined(run, rig, full)) == {6, 10}


def test_one_held_value_in_a_drive_tells_no_growth(run, rig, full):
    held(run, {6: 100.0})
    direct(run, {25: 4.0, 26: 4.5})
    assert joined(run, rig, full) == pytest.approx({25: 0.0, 26: 0.5})


def test_a_second_drive_begins_where_the_rest_ended(rig, full, driven):
    first, second = driven(rig, 30, (4, 24)), driven(rig, 30, (4, 24))
    both = replace(
        first, time_s=np.arange(60) + 1.0, channels=np.vstack([first.channels, second.channels]),
        ages_s=np.zeros((60, 16)), omega=np.tile(first.omega, 2), coverage=np.vstack([first.coverage] * 2),
        inputs={name: np.tile(column, 2) for name, column in first.inputs.items()},
    )  # fmt: skip
    both.inputs["displacement_direct"][:] = NAN
    held(both, {6: 100.0, 10: 106.0, 22: 112.0, 36: 300.0, 40: 302.0})
    direct(both, {25: 1.0, 33: -2.0})
    out = joined(both, rig, full)
    stopped = 3.0 + 12.0 + 2.0 / 12.0 * 6.0
    assert out[25] == pytest.approx(stopped)
    assert out[33] == pytest.approx(stopped - 3.0)
    assert out[36] == pytest.approx(stopped - 3.0 + 1.0)


def test_the_sd_is_that_of_many_noisy_copies(rig, full, driven):
    """Two rests and a drive: read every second at rest, every fourth while driving, all equally noisy."""
    dice, copies = np.random.default_rng(4), []
    model = full.with_values({"displacement.sd": 0.2})
    for _ in range(800):
        run = driven(rig, 45, (12, 30))
        run.inputs["displacement_direct"][:] = 0.2 * dice.standard_normal(45)
        held(run, {t: 0.2 * dice.standard_normal() for t in (14, 18, 22, 26, 29)})
        copies.append(displacement.joined(run, rig, model).um)
    measured, said = np.std(copies, axis=0), displacement.joined(run, rig, model).sd
    for second in (22, 26, 33, 40):  # 14 and 18 are in the half stroke as well
        assert said[second - 1] == pytest.approx(measured[second - 1], rel=0.12)
    assert said[39] > 2 * 0.2  # the join is what limits a reference at rest


def test_a_warm_probe_is_taken_off(run, rig, full):
    run.inputs["probe"][:] = 22 + np.linspace(0, 2.9, 30)
    held(run, {6: 100.0, 10: 100.0, 22: 100.0})
    direct(run, {1: 0.0})
    model = full.with_values({"displacement.probe": 0.2})
    out = joined(run, rig, model)
    assert out[10] - out[6] == pytest.approx(-0.2 * 0.4)
    assert out[22] - out[6] == pytest.approx(-0.2 * 1.6)


def test_a_warm_bar_is_added(run, rig, full):
    run.inputs["bar"][:] = 22 + np.linspace(0, 2.9, 30)
    held(run, {6: 100.0, 10: 100.0, 22: 100.0})
    out = joined(run, rig, full.with_values({"displacement.bar": 0.5}))
    assert out[22] - out[6] == pytest.approx(0.5 * 1.6)
    np.testing.assert_allclose(
        displacement.jig_expansion(run, full.with_values({"displacement.bar": 0.5})), -0.05 * np.arange(30), atol=1e-9
    )


def test_without_probe_and_bar_nothing_is_corrected(run, full):
    run.inputs["bar"][:] = 22 + np.arange(30)
    assert (displacement.jig_expansion(run, model_of([])) == 0).all()
    bare = replace(run, inputs={})
    assert (displacement.jig_expansion(bare, full) == 0).all()


def test_phases_are_drives_and_rests_in_order(run):
    run.omega[10] = np.nan
    found = [(driving, ticks[0] + 1, ticks[-1] + 1) for driving, ticks in phases(run)]
    assert found == [(False, 1, 4), (True, 5, 10), (False, 11, 11), (True, 12, 24), (False, 25, 30)]
