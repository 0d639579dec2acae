"""The elongation from readings: one zero for all drives, another for each rest, joined by what the model leaves."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.accuracy.reference import left_alone
from estimator.accuracy.review import review
from estimator.batch.trial import Trial


@pytest.fixture(scope="module")
def lived(rig, full, driven, live):
    """A drive that grows by micrometres a minute, and rest; the direct reading's zero is another one."""
    run = live(full, rig, driven(rig, 400, (40, 250)), seed=8)
    measured, direct = run.recording.channels.copy(), np.full(400, np.nan)
    driving = run.recording.omega > 0
    measured[~driving, rig.index("displacement")] = np.nan
    direct[~driving] = run.elongation_um[~driving] - 40.0 * (run.recording.time_s[~driving] > 100)
    inputs = {**run.recording.inputs, "displacement_direct": direct}
    return replace(run, recording=replace(run.recording, channels=measured, inputs=inputs))


def test_the_reference_is_the_growth_whatever_the_zeros(lived, rig, full):
    found = review(lived.recording, rig, full)
    off = found.reference - lived.elongation_um
    read = np.isfinite(off)
    assert read[260:].all()
    assert abs(off[260:].mean()) < 2.0 * found.readings.sd[260:].mean()
    assert np.nanmax(np.abs(off)) < 1.0
    assert found.readings.sd[300] < 0.3


def test_the_model_that_joins_may_be_wrong(lived, rig, full):
    """It stands for half a minute around a stop, its growth for nothing."""
    weak = full.with_values({"nut_friction.power": 0.7 * full["nut_friction.power"]})
    off = review(lived.recording, rig, weak)
    assert abs(np.nanmean((off.reference - lived.elongation_um)[260:])) < 0.5
    assert abs(np.nanmean(off.errors["open_loop"][260:])) > 1.0


def test_what_a_reading_has_beside_growth_is_no_growth(lived, rig, full):
    """Without a model of the displacement its growth alone is taken off, by which the join comes out the same."""
    alone = Trial(full, rig, lived.recording).pose(full).run.grown
    left = left_alone(lived.recording, rig, full, np.append(0.0, alone))
    later = left_alone(lived.recording, rig, full, np.append(0.0, alone) + 7.0)
    np.testing.assert_allclose(left.um, later.um, atol=1e-9)
    assert np.isnan(
        left.um[np.isnan(lived.recording.inputs["displacement_direct"]) & ~(lived.recording.omega > 0)]
    ).all()


@pytest.fixture
def shift(rig, driven):
    """Two drives of 100 s, each with a rest of 200 s after it, read as `held` and `direct` say; nothing grows."""
    one = driven(rig, 300, (0, 100))
    run = replace(
        one, time_s=np.arange(600) + 1.0, channels=np.vstack([one.channels] * 2), ages_s=np.zeros((600, 16)),
        omega=np.tile(one.omega, 2), coverage=np.vstack([one.coverage] * 2), unevenness=np.ones(600),
        inputs={name: np.tile(column, 2) for name, column in one.inputs.items()},
    )  # fmt: skip
    run.inputs["displacement_direct"][:] = np.nan
    return run


def read(run, rig, model, held, direct):
    """What is joined of these readings (600,), every fourth second while driving, each second at rest."""
    run.channels[3::4, 15] = np.broadcast_to(held, 600)[3::4]
    run.inputs["displacement_direct"][:] = direct
    return left_alone(run, rig, model, np.zeros(600))


def test_all_drives_have_the_zero_of_the_first(shift, rig, full):
    """Between them something came loose by 2 um where the disc stands, or the join at a stop was wrong by it."""
    held, direct = np.where(shift.time_s < 300, 100.0, 103.0), np.where(shift.time_s < 300, -7.0, 5.0)
    found = read(shift, rig, full, held, direct)
    drives = shift.omega > 0
    np.testing.assert_allclose(found.um[drives & (shift.time_s < 300)][3::4], 0.0, atol=1e-9)
    np.testing.assert_allclose(found.um[drives & (shift.time_s > 300)][3::4], 3.0, atol=1e-9)
    np.testing.assert_allclose(found.um[400:], 3.0, atol=1e-9)  # joined to the drive before


def test_a_rest_goes_from_the_drive_before_to_the_one_after(shift, rig, full):
    held = np.where(shift.time_s < 300, 100.0, 101.0)
    found = read(shift, rig, full, held, 40.0)
    np.testing.assert_allclose(found.um[[100, 298]], [0.0, 1.0], atol=1e-6)
    np.testing.assert_allclose(np.diff(found.um[100:299]), 1.0 / 198, atol=1e-6)
    assert np.isnan(found.um[299])  # the screw may have turned when that was read


def test_what_the_dial_shows_while_driving_and_what_is_held_at_rest_is_not_used(shift, rig, full):
    found = read(shift, rig, full, np.where(shift.omega > 0, 100.0, 900.0), np.where(shift.omega > 0, -55.0, 4.0))
    assert np.nanmax(np.abs(found.um)) < 1e-9
    assert (np.isfinite(found.um) == np.isfinite(found.level)).all()


def test_a_reading_counts_from_when_it_was_taken(shift, rig, full):
    """The same growth of 0.1 um/s, read half a second late."""
    shift.ages_s[:, 15] = 0.5
    truth = 0.1 * np.minimum(shift.time_s - 1.0, 99.0)
    shift.channels[3::4, 15] = (truth - 0.05)[3::4]
    shift.inputs["displacement_direct"][:] = truth
    found = left_alone(shift, rig, full, truth)
    np.testing.assert_allclose(found.um[3:100:4], 0.0, atol=1e-9)


def test_the_sd_is_that_of_many_noisy_copies(shift, rig, full):
    dice, copies, model = (
        np.random.default_rng(4),
        [],
        full.with_values({"displacement.sd": 0.2, "displacement.zero_walk": 0.0}),
    )
    for _ in range(400):
        held, direct = 0.2 * dice.standard_normal((2, 600))
        copies.append(read(shift, rig, model, held, direct).level)
    measured, said = np.std(copies, axis=0), read(shift, rig, model, held, direct).sd
    for second in (48, 200, 348, 500):
        assert said[second - 1] == pytest.approx(measured[second - 1], rel=0.15)
    assert said[47] < 0.2  # a level knows more than one reading
    assert said[347] == pytest.approx(said[47], rel=0.2)  # and the second drive as much as the first


def test_the_sd_grows_by_what_the_zero_may_have_walked(shift, rig, full):
    walks = full.with_values({"displacement.sd": 1e-6, "displacement.zero_walk": 0.01})
    found = read(shift, rig, walks, 100.0, 0.0)
    np.testing.assert_allclose(found.sd[[203, 503]], 0.01 * np.sqrt([200.0, 500.0]), rtol=1e-3)


def test_errors_of_the_joins_do_not_add_up(rig, full, driven):
    """Twenty drives and rests; what the model alone leaves bends at each stop, so that each join is wrong alike."""
    one, count = driven(rig, 400, (0, 180)), 20
    long = replace(
        one, time_s=np.arange(400 * count) + 1.0, channels=np.vstack([one.channels] * count),
        ages_s=np.zeros((400 * count, 16)), omega=np.tile(one.omega, count), coverage=np.vstack([one.coverage] * count),
        unevenness=np.ones(400 * count), inputs={name: np.tile(column, count) for name, column in one.inputs.items()},
    )  # fmt: skip
    truth = np.tile(np.interp(one.time_s, [0, 180, 210, 400], [0.0, 8.0, 6.5, 0.0]), count)
    dice = np.random.default_rng(2)
    driving = long.omega > 0
    zeros = np.repeat(dice.normal(0, 30, count), 400)  # where the disc stopped
    long.channels[::5, 15] = np.where(driving, 50.0 + truth, np.nan)[::5] + dice.normal(0, 0.1, len(truth))[::5]
    long.inputs["displacement_direct"][:] = np.where(driving, np.nan, truth + zeros + dice.normal(0, 0.1, len(truth)))
    off = left_alone(long, rig, full, np.zeros(len(truth))).level - truth
    middles = np.array([np.nanmean(off[400 * k + 40 : 400 * k + 160]) for k in range(count)])
    assert np.abs(middles - middles[0]).max() < 0.1  # of what each join is wrong by, about half a micrometre
    assert np.nanmax(np.abs(off)) < 1.5
