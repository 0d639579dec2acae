"""Errors one tick ahead, minutes ahead and open loop, against plain loops with the filter."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from estimator.accuracy.horizon import HORIZONS, errors, horizons, overall
from estimator.batch.coarse import coarse
from estimator.batch.trial import Trial
from estimator.batch.trials import Trials
from estimator.filter import Filter
from tests.conftest import stepped

TICK_S = 10
SECONDS = 1340
AHEAD = 600 // TICK_S


@pytest.fixture(scope="module")
def lived(small, small_model, driven, live) -> tuple:
    """Rig and recording at a long tick, with gaps, a spike, and a displacement that is read late for the first time."""
    drive, rig = coarse(driven(small, SECONDS, (50, 900), stroke=(0.0, 100.0)), small, TICK_S)
    run = live(small_model, rig, drive, seed=2, process=True).recording.rows(slice(2, None))
    run.channels[:7, 4] = np.nan
    run.channels[30:50, 1] = run.channels[80] = np.nan
    run.channels[60, 2] += 40.0
    return rig, run


@pytest.fixture(scope="module")
def trial(lived, small_model) -> Trial:
    rig, run = lived
    return Trial(small_model, rig, run)


@pytest.fixture(scope="module")
def found(trial, small_model):
    return horizons(trial, small_model)


@pytest.fixture(scope="module")
def track(lived, small_model):
    rig, run = lived
    return stepped(Filter(small_model, rig), run)


def test_one_step_is_the_filters_innovation_of_what_it_fuses(found, track):
    """But for the first reading of the displacement, which tells its own zero."""
    expected = np.where(track.fused, track.innovation, np.nan)[1:]
    told = np.flatnonzero(track.fused[1:, 4])[0]
    assert np.isfinite(expected[told, 4])
    expected[told, 4] = np.nan
    np.testing.assert_allclose(found.one_step, expected, rtol=0, atol=1e-9)
    assert np.isnan(found.one_step[59, 2])


def test_ahead_is_what_a_filter_says_that_hears_nothing_for_ten_minutes(found, lived, trial, small_model, track):
    rig, run = lived
    expected = np.full_like(found.ahead, np.nan)
    hearing = Filter(small_model, rig)
    hearing.step(run.sample(0))
    for start in range(len(run) - 1 - AHEAD):
        hearing.step(run.sample(start + 1))
        if start % (60 // TICK_S):
            continue
        deaf = copy.deepcopy(hearing, {id(each): each for each in (rig, small_model)})
        deaf.mute = lambda _: np.ones(5, dtype=bool)
        blind = stepped(deaf, run.rows(slice(start + 2, start + 2 + AHEAD)))
        seen = np.isfinite(run.channels[start + 1 + AHEAD]) & ~trial.muted[start + AHEAD]
        seen[4] &= track.fused[: start + 2, 4].any()
        expected[start + AHEAD, seen] = blind.innovation[-1, seen]
    assert (np.isfinite(expected).sum(axis=0) > 10).all()
    np.testing.assert_allclose(found.ahead, expected, rtol=0, atol=1e-9)


def test_open_loop_is_the_reading_less_what_the_model_alone_says(found, track, trial):
    """The displacement less its mean: its zero has no meaning."""
    expected = np.where(trial.muted, np.nan, track.measured[1:] - track.open_loop[1:])
    expected[:, 4] -= np.nanmean(expected[:, 4])
    np.testing.assert_allclose(found.open_loop, expected, rtol=0, atol=1e-9)


def test_a_zero_that_is_known_stays_in_the_open_loop_error(small_model, lived):
    rig, run = lived
    known = small_model.with_values({"displacement.zero_sd": 0.3})
    trial = Trial(known, rig, replace(run, channels=run.channels + np.array([0, 0, 0, 0, 3.0])))
    assert np.nanmean(horizons(trial, known).open_loop[:, 4]) > 2


def test_late_readings_are_expected_earlier(small_model, lived, found):
    """A reading that was taken half a tick before its close is not yet as warm as the model is at the close."""
    rig, run = lived
    late = np.full_like(run.ages_s, TICK_S / 2)
    other = horizons(Trial(small_model, rig, replace(run, ages_s=late)), small_model)
    warming = slice(8, 20)
    assert np.nanmean((other.open_loop - found.open_loop)[warming, 1:3]) > 0.01


def test_the_elongation_is_foretold_as_the_filter_would(found, lived, small_model, track):
    """One tick ahead with the readings up to there; open loop as the filter's own open-loop run."""
    rig, run = lived
    np.testing.assert_allclose(found.elongation["open_loop"], track.open_loop_um[1:], rtol=0, atol=1e-9)
    for k in (3, 40, 120):
        last = run.time_s[k - 1]
        blind = stepped(Filter(small_model, rig, lambda t, last=last: np.full(5, t > last)), run.rows(slice(0, k + 1)))
        assert found.elongation["one_step"][k - 1] == pytest.approx(blind.elongation_um[-1], abs=1e-9)
    start = 60 // TICK_S
    blind = stepped(Filter(small_model, rig, lambda t: np.full(5, t > run.time_s[start + 1])), run)
    assert found.elongation["ahead"][start + AHEAD] == pytest.approx(blind.elongation_um[start + 1 + AHEAD], abs=1e-9)


def test_where_the_elongation_is_known_readings_do_not_count(found):
    true = found.elongation["open_loop"] + 3.0
    assert overall([replace(found, reference={"open_loop": true})], "open_loop").elongation_um == pytest.approx(3.0)
    half = np.where(np.arange(len(true)) < 50, true, np.nan)
    errors = replace(found, reference={"open_loop": half}).elongation_errors("open_loop")
    assert errors[:50, 0] == pytest.approx(3.0)
    assert np.isnan(errors[:50, 1]).all()
    np.testing.assert_array_equal(errors[50:, 1], found.open_loop[50:, 4])


def test_errors_are_roots_of_mean_squares_over_all_recordings(found, trial, small_model):
    once, twice = overall([found], "one_step"), overall([found, found], "one_step")
    heat, length = found.one_step[:, :4], found.one_step[:, 4]
    assert (twice.temperature_K, twice.elongation_um) == pytest.approx((once.temperature_K, once.elongation_um))
    assert once.temperature_K == pytest.approx(np.sqrt(np.nanmean(heat**2)))
    assert once.elongation_um == pytest.approx(np.sqrt(np.nanmean(length**2)))
    worse = replace(found.where(np.arange(len(heat)) < 100), one_step=np.full((100, 5), 2.0))
    both = overall([found, worse], "one_step")
    squares = np.nansum(heat**2) + 400 * 4.0
    assert both.temperature_K == pytest.approx(np.sqrt(squares / (np.isfinite(heat).sum() + 400)))
    told = errors(Trials([trial]), small_model)
    assert set(told) == set(HORIZONS)
    assert told["one_step"] == once
    assert told["ahead"] == overall([found], "ahead")


def test_a_wrong_model_is_worse_the_longer_it_is_alone(trial, small_model):
    right = errors(Trials([trial]), small_model)
    wrong = errors(Trials([trial]), small_model.with_values({"nut_friction.power": 100.0}))
    worse = [wrong[name].temperature_K / right[name].temperature_K for name in HORIZONS]
    assert worse[0] < worse[1] < worse[2]
    assert worse[1] > 3


def test_a_recording_shorter_than_ten_minutes_says_nothing_of_what_is_ahead(lived, small_model):
    rig, run = lived
    found = errors(Trials([Trial(small_model, rig, run.rows(slice(0, AHEAD)))]), small_model)
    assert np.isnan([found["ahead"].temperature_K, found["ahead"].elongation_um]).all()
    assert np.isfinite([found["one_step"].temperature_K, found["open_loop"].elongation_um]).all()


def test_a_model_that_reads_no_displacement_foretells_none_but_its_growth_is_judged_by_it(lived, trial, small_model):
    rig, run = lived
    bare = small_model - "displacement"
    found, own = errors(Trials([Trial(bare, rig, run)]), bare), errors(Trials([trial]), small_model)
    assert np.isfinite([error.temperature_K for error in found.values()]).all()
    assert np.isnan([found["one_step"].elongation_um, found["ahead"].elongation_um]).all()
    assert found["open_loop"].elongation_um == pytest.approx(own["open_loop"].elongation_um, rel=0.1)
