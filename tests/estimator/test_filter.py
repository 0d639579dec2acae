"""The filter on whole runs with gaps, spikes and silence; that it says the same tick by tick: batch/test_replay.py."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.replay import replay
from estimator.faults.fault import Fault
from estimator.filter import Filter
from estimator.record import Recording
from estimator.step import Mode
from tests.conftest import stepped

SECONDS = 150


@pytest.fixture(scope="module")
def run(rig, full, driven, live) -> Recording:
    """A drive of the paper's rig and the first minute of its rest, as the model has it, with noise."""
    drive = driven(rig, SECONDS, (20, 90))
    drive.inputs["probe"][:] = 22 + np.linspace(0, 2, SECONDS)
    return live(full, rig, drive, seed=1).recording


@pytest.fixture(scope="module")
def track(rig, full, run):
    return replay(full, rig, run)


def copy(run: Recording) -> Recording:
    """The recording with arrays of its own, to break."""
    inputs = {name: column.copy() for name, column in run.inputs.items()}
    return replace(
        run, channels=run.channels.copy(), inputs=inputs, omega=run.omega.copy(), coverage=run.coverage.copy()
    )


def silent_telemeter(run: Recording) -> None:
    run.channels[50:90, :15] = np.nan


def missing_channels(run: Recording) -> None:
    run.channels[:, [1, 6]] = np.nan
    run.channels[30:60, 11] = np.nan


def scattered_gaps(run: Recording) -> None:
    run.channels[np.random.default_rng(0).random(run.channels.shape) < 0.4] = np.nan
    run.channels[70] = np.nan


def missing_drive(run: Recording) -> None:
    run.omega[40:43] = np.nan
    run.coverage[40:44] = np.nan
    run.inputs["position"][40:60] = np.nan


def missing_inputs(run: Recording) -> None:
    for name in ("ambient", "base", "probe", "nut"):
        run.inputs[name][:25] = np.nan
    run.inputs["bar"][:] = np.nan


def late_start(run: Recording) -> None:
    run.channels[:7, :15] = np.nan


BREAKS = [silent_telemeter, missing_channels, scattered_gaps, missing_drive, missing_inputs, late_start]


@pytest.mark.parametrize("broken", BREAKS)
def test_a_gap_never_reaches_the_state(rig, full, run, track, broken):
    log = copy(run)
    broken(log)
    found = replay(full, rig, log)
    begun = found.mode != Mode.INIT
    assert begun.sum() >= SECONDS - 8
    np.testing.assert_array_equal(found.fused[begun], np.isfinite(log.channels[begun]))
    assert np.isfinite(found.profile_C[begun]).all()
    assert abs(found.elongation_um - track.elongation_um)[begun].max() < 1.5


def test_any_subset_of_channels_is_enough_to_start(rig, full, run):
    for used in ([0], [15, 4], [3, 9, 14]):
        log = copy(run)
        log.channels[:, [i for i in range(16) if i not in used]] = np.nan
        track = replay(full, rig, log)
        assert (track.nis_channels[1:] <= len(used)).all()
        assert track.nis_channels.max() == len(used)
        assert abs(track.elongation_um[-1] - track.open_loop_um[-1]) < 4 * track.sigma_um[-1]


def test_it_starts_at_the_first_sample_with_a_thermometer(rig, full, run):
    log = copy(run)
    late_start(log)
    filter_ = Filter(full, rig)
    waiting = [filter_.step(log.sample(k)) for k in range(7)]
    assert {step.mode for step in waiting} == {Mode.INIT}
    assert {why for step in waiting for why in step.why} == {"waiting for a thermometer"}
    assert np.isnan([step.elongation_um for step in waiting]).all()
    first = filter_.step(log.sample(7))
    assert first.mode == Mode.PREDICT
    assert first.elongation_um == pytest.approx(0, abs=1e-9)
    assert first.sigma_um == pytest.approx(0, abs=1e-6)
    assert filter_.step(log.sample(8)).mode == Mode.PREDICT


def test_modes_say_what_the_estimate_rests_on(rig, full, run):
    log = copy(run)
    log.channels[60:65, :15] = np.nan
    mode = replay(full, rig, log).mode
    read = np.isfinite(log.channels[:, 15])
    expected = np.where(read, 2, 1)
    expected[60:65] = np.where(read[60:65], 2, 3)
    np.testing.assert_array_equal(mode, expected)
    assert [int(m) for m in Mode] == [0, 1, 2, 3, 14]


def test_a_spike_is_reported_and_not_fused(rig, full, run, track):
    log = copy(run)
    log.channels[100, 6] += 40
    filter_ = Filter(full, rig)
    steps = [filter_.step(sample) for sample in log]
    assert (steps[100].fused[6], steps[100].why[6]) == (False, "implausible jump")
    assert steps[100].innovation[6] == pytest.approx(40, abs=0.5)
    assert sum("implausible jump" in step.why for step in steps) == 1
    assert max(abs(step.elongation_um - whole) for step, whole in zip(steps, track.elongation_um, strict=True)) < 0.05


def test_a_step_that_stays_is_left_out(rig, full, run, track):
    log = copy(run)
    log.channels[100:, 6] += 40
    left = replay(full, rig, log)
    np.testing.assert_array_equal(left.fused[:, 6], np.arange(SECONDS) < 100)
    assert Fault(left.fault[-1, 6]) == Fault.JUMPED
    assert abs(left.elongation_um - track.elongation_um).max() < 0.1


def test_one_good_reading_ends_the_count_of_bad_ones(rig, full, run):
    log = copy(run)
    log.channels[[100, 101, 102, 103, 105, 106, 107], 6] += 40
    fused = replay(full, rig, log).fused[100:108, 6]
    np.testing.assert_array_equal(fused, [False] * 4 + [True] + [False] * 3)


def test_muted_channels_are_compared_but_not_fused(rig, full, run):
    quiet = np.arange(16) == 4
    filter_ = Filter(full, rig, lambda t: quiet & (t > 30))
    log = copy(run)
    log.channels[:, 4] += np.where(np.arange(SECONDS) > 30, 1.0, 0.0)
    muted = stepped(filter_, log)
    np.testing.assert_array_equal(muted.fused[:, 4], np.arange(SECONDS) < 30)
    assert muted.innovation[100, 4] == pytest.approx(1.0, abs=0.2)
    log.channels[31:, 4] = np.nan
    without = replay(full, rig, log)
    np.testing.assert_allclose(muted.elongation_um[31:], without.elongation_um[31:], atol=0.01)
    assert filter_.step(run.sample(100)).why[4] == "muted"


@pytest.mark.parametrize("spike", [40.0, -40.0, 5.0, 1.0])
@pytest.mark.parametrize("channel", [0, 6])
def test_a_spike_in_the_first_sample_is_not_taken_for_the_start(spike, channel, rig, full, run, track):
    log = copy(run)
    log.channels[0, channel] += spike
    spiked = replay(full, rig, log)
    if abs(spike) > 10:  # no temperature; less may be a warm bearing, and is corrected by the readings that follow
        np.testing.assert_array_equal(spiked.fused[:3, channel], [False, True, True])
    error = abs(spiked.elongation_um - track.elongation_um)
    assert error.max() < 0.3
    began = abs(spiked.elongation_um) < 1e-9
    assert (error <= 4 * spiked.sigma_um)[~began].all()


def test_a_channel_muted_from_the_start_is_as_if_it_were_not_there(rig, full, run):
    """Whatever it reads."""
    log = copy(run)
    log.channels[:, 6] = 100.0
    muted = replay(full, rig, log, lambda t: np.arange(16) == 6)
    log.channels[:, 6] = np.nan
    without = replay(full, rig, log)
    np.testing.assert_allclose(muted.elongation_um, without.elongation_um, rtol=0, atol=1e-9)
    np.testing.assert_allclose(muted.sigma_um, without.sigma_um, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("tolerance", "fall"), [(0.0, 1.4), (0.01, 1.3)])
def test_sigma_grows_while_coasting_and_falls_when_readings_return(tolerance, fall, rig, full, run):
    """Thermometers tell nothing of the expansion coefficient: the better it is known, the more they help."""
    log = copy(run)
    log.channels[40:100] = np.nan
    known = replace(rig, screw=replace(rig.screw, expansion_tolerance=tolerance))
    track = replay(full, known, log)
    assert (track.mode[40:100] == Mode.COASTING).all()
    assert (np.diff(track.sigma_um[39:90]) > 0).all()
    assert track.sigma_um[99] > 3 * track.sigma_um[39]
    assert track.sigma_um[100] < track.sigma_um[99] / fall


def test_coasting_follows_the_model(rig, full, run):
    """Without a reading after the start the estimate is the open-loop run, and never repeats the last value."""
    log = copy(run)
    log.channels[1:] = np.nan
    track = replay(full, rig, log)
    np.testing.assert_allclose(track.elongation_um, track.open_loop_um, atol=1e-9)
    assert track.elongation_um[89] > 15


def test_nis_is_nan_without_readings(rig, full, run):
    log = copy(run)
    log.channels[50] = np.nan
    track = replay(full, rig, log)
    assert np.isnan(track.nis[[0, 50]]).all()
    assert np.isfinite(np.delete(track.nis, [0, 50])).all()
    assert track.nis_channels[50] == 0


def test_table_error_is_growth_between_anchor_and_nut_longer_is_positive(run, track):
    k = 89
    rise = track.profile_C[k] - track.profile_C[0]
    nut = 673.5 - run.inputs["position"][k]
    x = np.linspace(nut, 889.0, 2000)
    expected = 12e-3 * np.trapezoid(np.interp(x, track.x_mm, rise), x)
    assert expected > 3
    assert track.error_at_table_um[k] == pytest.approx(expected, abs=0.05)


def test_table_error_anywhere_is_that_at_the_table_when_it_is_there(rig, full, run):
    estimate = Filter(full, rig)
    assert np.isnan(estimate.table_errors(np.array([0.0, 100.0])).error_um).all()
    for k in range(91):
        step = estimate.step(run.sample(k))
        if k in (0, 90):
            table = estimate.table_errors(np.array([-50.0, step.position_mm]))
            assert table.error_um[0, 1] == pytest.approx(step.error_at_table_um, rel=1e-12)
            assert table.sd_um[0, 1] == pytest.approx(step.error_at_table_sd_um, rel=1e-12)
    assert table.error_um[0, 0] < table.error_um[0, 1] - 1  # nearer to the anchor less of the screw grows


def test_table_error_is_unknown_without_a_position_and_grows_with_distance(rig, full, run):
    log = copy(run)
    log.inputs["position"][98:101] = np.nan  # two ticks late it is still where it was, three it is not known
    log.inputs["position"][101:] = np.where(np.arange(SECONDS - 101) % 2, 0.0, 400.0)
    track = replay(full, rig, log)
    error = track.error_at_table_um
    assert list(np.isnan(error[97:102])) == [False, False, False, True, False]
    assert list(track.position_mm[97:100]) == [log.inputs["position"][97]] * 3
    near, far = error[102:-1:2], error[103::2]
    assert (near > 0).all()
    assert (far > near + 1).all()


def test_covariance_stays_symmetric_and_positive_over_hundreds_of_steps(small, small_model, driven, live):
    model = small_model.with_values({"thermometers.gain_sd": 0.0})  # it is no part of the filter's covariance
    drive = driven(small, 400, (10, 250), stroke=(0.0, 100.0))
    log = live(model, small, drive, seed=2).recording
    log.channels[100:200] = np.nan
    filter_ = Filter(model, small)
    track = stepped(filter_, log)
    P = filter_.fusion.P
    assert (P == P.T).all()
    assert np.linalg.eigvalsh(P).min() > -1e-12 * np.linalg.eigvalsh(P).max()
    assert (np.diag(P) > 0).all()
    assert np.isfinite(track.sigma_um).all()
    assert track.sigma_um[-1] < 1
