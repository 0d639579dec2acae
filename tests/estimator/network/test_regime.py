"""Which regime holds, and that one which lasts is where the strokes are on the whole."""

import numpy as np
import pytest

from estimator.network.regime import CLOSE, COVERAGE_STEP, SPEED_STEP, Regimes


def test_a_regime_holds_while_speed_and_place_hold():
    regimes, here, there = Regimes(1.0), np.array([1.0, 1, 0, 0]), np.array([0.0, 0, 1, 1])
    assert [regimes.index(0.0, here), regimes.index(0.0, here), regimes.index(0.0, there)] == [0, 0, 1]
    assert [regimes.index(100.0, here), regimes.index(103.0, here), regimes.index(100.0, here)] == [2, 2, 2]
    assert regimes.index(0.3, here) == 0  # slower than 5 rpm is at rest
    assert regimes.index(160.0, here) == 3
    assert [each.omega for each in regimes.met] == [0.0, 0.0, 100.0, 160.0]


def test_at_rest_another_warmth_is_another_regime():
    regimes, here = Regimes(1.0), np.array([1.0, 0.0])
    warmths = (0.0, 2.0, 3.0, 3.0, 2.0)
    assert [regimes.index(0.0, here, rest_K=warmth) for warmth in warmths] == [0, 1, 2, 2, 1]
    assert [each.rest_K for each in regimes.met] == [0.0, 2.0, 3.0]


def test_a_moving_regime_is_the_mean_of_the_last_minute():
    regimes = Regimes(1.0)
    here, there = np.array([1.0, 0.0]), np.array([0.0, 1.0])
    for k in range(200):
        last = regimes.index(100.0, here if k < 60 else there)
    np.testing.assert_allclose(regimes.met[last].coverage, there, atol=COVERAGE_STEP + 1e-9)
    np.testing.assert_array_equal(regimes.met[0].coverage, here)
    held = int(60 * COVERAGE_STEP) + 1  # s: the mean moves by a sixtieth each
    assert len(regimes.met) == pytest.approx(1 + 60 / held, abs=1)


@pytest.mark.parametrize("tick_s", [1.0, 5.0])
def test_a_regime_that_lasts_is_the_mean_of_all_strokes(tick_s):
    """The tick in which the drive begins is slower, and the nut at one end: near enough to hold for the whole drive."""
    regimes, cells = Regimes(tick_s), np.arange(60)
    ticks = (np.arange(0.0, 260.0, tick_s)[:, None] + np.linspace(0.0, tick_s, 50)) / 7.3
    place = 20 + 20 * np.abs(2 * (ticks % 1.0) - 1)
    covers = ((cells >= place[..., None] - 9) & (cells < place[..., None] + 9)).mean(axis=1)
    held = [regimes.index(96.0 if k == 0 else 100.0, cover) for k, cover in enumerate(covers)]
    settled = regimes.met[held[-1]]
    assert settled.omega == pytest.approx(100.0, rel=CLOSE * SPEED_STEP)
    apart = np.abs(settled.coverage - covers.mean(axis=0)).sum() / 2 / settled.coverage.sum()
    assert apart < 1.1 * CLOSE * COVERAGE_STEP
    assert held[-1] != held[int(50.0 / tick_s)]
    assert len(set(held[int(180.0 / tick_s) :])) == 1  # a minute holds 8.2 strokes, and makes no regime of its own
    assert regimes.index(90.0, covers[-1]) == held[-1]
    for _ in range(int(60.0 / tick_s)):
        last = regimes.index(80.0, covers[-1])
    assert last != held[-1]
