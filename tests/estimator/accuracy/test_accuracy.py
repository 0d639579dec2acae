"""Bands, lines and the estimates that need no model."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from estimator.accuracy import polyline
from estimator.accuracy.accuracy import accuracy, least_squares_line
from estimator.accuracy.review import overall, review

NAN = np.nan
LENGTHS = st.floats(-50, 50)


def test_a_band_is_lowest_and_highest_error():
    found = accuracy(np.array([NAN, -2.5, 0.3, 2.58, NAN]))
    assert found.band_um == (-2.5, 2.58)
    assert found.width_um == pytest.approx(5.08)
    assert found.rms_um == pytest.approx(np.sqrt((6.25 + 0.09 + 2.58**2) / 3))
    assert np.isnan([found.cooldown_max_um, found.coverage_2sigma]).all()


def test_two_sigma_and_cooldown_are_counted_where_there_is_a_reference():
    error = np.array([0.1, -3.0, NAN, 0.5])
    found = accuracy(error, np.array([1.0, 1.0, 1.0, 0.2]), np.array([True, False, True, True]))
    assert found.coverage_2sigma == pytest.approx(1 / 3)
    assert found.cooldown_max_um == 0.5


def test_without_a_reference_there_is_no_figure():
    found = accuracy(np.full(3, NAN), np.ones(3), np.ones(3, dtype=bool))
    assert np.isnan([*found.band_um, found.rms_um, found.cooldown_max_um, found.coverage_2sigma]).all()


@given(st.floats(0.2, 3), LENGTHS, st.lists(LENGTHS, min_size=3, max_size=9, unique_by=lambda x: round(x, 1)))
def test_the_line_is_found_again(a, b, estimate):
    x = np.array([*estimate, 7.0])
    reference = a * x + b
    reference[-1] = NAN
    slope, level, band = least_squares_line(x, reference)
    assert (slope, level) == (pytest.approx(a, abs=1e-5), pytest.approx(b, abs=1e-4))
    assert band == pytest.approx((0, 0), abs=1e-4)


def test_the_band_around_the_line_is_reference_minus_line():
    slope, level, band = least_squares_line(np.array([0.0, 1, 2, 3]), np.array([0.0, 1, 2, 7]))
    assert (slope, level) == (pytest.approx(2.2), pytest.approx(-0.8))
    assert band == pytest.approx((-1.6, 1.2))


@pytest.fixture(scope="module")
def run(rig, full, driven, live):
    """A drive and its cooldown as the model has it, with noise."""
    return live(full, rig, driven(rig, 90, (10, 50)), seed=4).recording


def test_the_polyline_joins_the_last_reading(run, rig, full):
    line = polyline.elongation(run, rig)
    joined, held = polyline.joined_polyline(run, rig, full, line), polyline.last_reading(run, rig, full, line)
    reading = run.channels[:, 15]
    np.testing.assert_allclose(held[60], reading[60] - reading[0] + line[0])
    np.testing.assert_allclose(joined[60:63], held[60] + line[60:63] - line[60])
    np.testing.assert_array_equal(held[60:63], held[60])


def test_before_the_first_reading_rivals_say_the_polyline_and_nothing(run, rig, full):
    line = polyline.elongation(run, rig)
    late = replace(run, channels=run.channels.copy())
    late.channels[:20, 15] = NAN
    np.testing.assert_array_equal(polyline.joined_polyline(late, rig, full, line)[:20], line[:20])
    assert (polyline.last_reading(late, rig, full, line)[:20] == 0).all()
    assert polyline.last_reading(late, rig, full, line)[21] == pytest.approx(line[21])


def scrambled(run, k: int):
    """The recording with another future after tick k."""
    dice = np.random.default_rng(0)
    future = replace(run, channels=run.channels.copy(), omega=run.omega.copy())
    future.channels[k:] += dice.normal(5, 5, future.channels[k:].shape)
    future.channels[k::2, 3] = NAN
    future.omega[k:] = 100.0
    return future


@pytest.mark.parametrize("k", [5, 31, 70])
def test_no_estimate_but_the_smoothed_looks_ahead(run, rig, full, k):
    now, then = review(run, rig, full), review(scrambled(run, k), rig, full)
    assert set(now.estimates) == {
        "filter", "smoothed", "open_loop", "polyline", "polyline_7", "polyline_joined", "last_reading",
    }  # fmt: skip
    for name, series in now.estimates.items():
        if name == "smoothed":
            assert not np.allclose(then.estimates[name][:k], series[:k], rtol=0, atol=1e-4)
            continue
        np.testing.assert_allclose(then.estimates[name][:k], series[:k], rtol=0, atol=1e-9, err_msg=name)
        assert name == "open_loop" or abs(then.estimates[name] - series)[k:].max() > 1, name


def test_errors_are_reference_minus_estimate(run, rig, full):
    truth = np.linspace(0, 3, 90)
    found = review(run, rig, full, truth_um=truth)
    assert found.reference_name == "truth"
    for name, error in found.errors.items():
        np.testing.assert_allclose(error, truth - found.estimates[name], err_msg=name)
    assert found.accuracy("polyline").band_um[1] == pytest.approx(np.max(truth - found.estimates["polyline"]))


def test_without_truth_a_reading_is_compared_with_the_prediction_before_its_use(run, rig, full):
    found = review(run, rig, full)
    assert found.reference_name == "readings"
    fused = found.track.fused[:, 15]
    assert fused.sum() == 30
    track = found.track
    at = np.flatnonzero(fused)[1:]
    before = track.elongation_um[at - 1] + track.open_loop_um[at] - track.open_loop_um[at - 1]
    np.testing.assert_allclose(found.errors["filter"][at], found.reference[at] - before, atol=1e-9)
    assert np.isfinite(found.errors["filter"][at]).sum() > 25
    np.testing.assert_allclose(found.sigma["filter"], np.hypot(track.sigma_um, found.readings.sd))
    assert np.isnan(found.errors["filter"][0])  # the first reading tells the zero, no more


def test_the_smoothed_estimate_is_not_judged_by_a_reading_that_it_is_made_of(run, rig, full):
    found = review(run, rig, full)
    fused = found.track.fused[:, 15]
    assert np.isnan(found.errors["smoothed"][fused]).all()
    unread = review(run, rig, full, mute=lambda _: np.arange(16) == 15)
    np.testing.assert_array_equal(np.isfinite(unread.errors["smoothed"]), np.isfinite(unread.readings.um))
    read = np.flatnonzero(np.isfinite(unread.readings.um))[1:]  # the first tick's growth is 0 by definition
    assert (unread.sigma["smoothed"] > unread.readings.sd)[read].all()  # a doubt of its own beside theirs


def test_nis_is_the_mean_over_fused_channels(run, rig, full):
    found = review(run, rig, full)
    known = np.isfinite(found.track.nis)  # the first sample only starts the filter
    assert found.nis_mean == pytest.approx(found.track.nis[known].sum() / found.track.nis_channels[known].sum())
    assert found.track.nis_channels.sum() == 90 * 15 + 30


def test_several_recordings_make_one_band(run, rig, full):
    one = review(run, rig, full, truth_um=np.zeros(90))
    two = review(run, rig, full, truth_um=np.full(90, 2.0))
    together = overall([one, two], "polyline")
    assert together.band_um == (one.accuracy("polyline").band_um[0], two.accuracy("polyline").band_um[1])
