"""A recording at a longer tick."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.coarse import coarse


@pytest.fixture(scope="module")
def lived(rig, full, driven, live):
    """A drive and some rest on the paper's rig."""
    return live(full, rig, driven(rig, 400, (20, 240)), seed=5).recording


@pytest.fixture(scope="module")
def five(rig, lived):
    """Five ticks in one."""
    broken = replace(lived, channels=lived.channels.copy(), omega=lived.omega * np.linspace(0.5, 1, 400))
    broken.channels[54, 6] = np.nan
    broken.channels[60:65, 7] = np.nan
    return broken, *coarse(broken, rig, 5)


def test_a_longer_tick_keeps_the_heat_where_it_fell(five):
    before, after, rig = five
    assert rig.tick_s == 5.0
    assert len(after) == 80
    heat = (before.omega[:, None] * before.coverage).reshape(80, 5, -1).sum(axis=1)
    np.testing.assert_allclose(5 * after.omega[:, None] * after.coverage, heat, rtol=1e-6, atol=1e-6)
    assert heat.max() > 10


def test_a_longer_tick_keeps_the_last_reading_and_its_age(five):
    before, after, _ = five
    np.testing.assert_array_equal(after.time_s, before.time_s[4::5])
    np.testing.assert_array_equal(after.channels[:10, :15], before.channels[4:50:5, :15])
    assert (after.channels[10, 6], after.ages_s[10, 6]) == (before.channels[53, 6], 1.0)
    assert np.isnan(after.channels[12, 7])
    assert after.ages_s[12, 7] == 0
    last = [k for k in range(50, 55) if np.isfinite(before.channels[k, 15])][-1]
    assert (after.channels[10, 15], after.ages_s[10, 15]) == (before.channels[last, 15], 54 - last)


def test_a_longer_tick_counts_ages_in_seconds_and_speed_as_it_was(half, driven):
    """At half a second: the fourth of five ticks is half a second before the end of them."""
    run = driven(half, 20, (0, 20))
    run.channels[3::5] = 22.0
    run.omega[:] = np.tile([1.0, 2.0, 3.0, 4.0, 5.0], 8)
    after, rig = coarse(replace(run, ages_s=np.full_like(run.channels, 0.2)), half, 5)
    assert rig.tick_s == 2.5
    np.testing.assert_allclose(np.diff(after.time_s), 2.5)
    np.testing.assert_allclose(after.ages_s, 0.7)
    np.testing.assert_allclose(after.omega, 3.0)
    np.testing.assert_allclose(after.unevenness, 11.0 / 9.0)


def test_a_longer_tick_means_its_inputs(rig, lived):
    slow = replace(lived, inputs={**lived.inputs, "ambient": np.arange(400.0), "base": np.full(400, np.nan)})
    slow.inputs["ambient"][:3] = np.nan
    after, _ = coarse(slow, rig, 5)
    np.testing.assert_allclose(after.inputs["ambient"][:3], [3.5, 7, 12])
    assert np.isnan(after.inputs["base"]).all()


def test_a_recording_shorter_than_the_longer_tick_stays_as_it_is(rig, lived):
    short, same = coarse(lived.rows(slice(0, 4)), rig, 5)
    assert len(short) == 4
    assert same is rig
