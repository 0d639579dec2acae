"""Standing still: told of fine sensors, never of coarse ones, in whatever portions the readings come."""

import numpy as np
import pytest

from estimator.faults.standstill import Standstill
from estimator.faults.suspects import STILL


def repeats_of(readings: np.ndarray, portion: int) -> np.ndarray:
    standstill, found = Standstill(np.ones(readings.shape[1], dtype=bool)), []
    for k in range(0, len(readings), portion):
        repeats = standstill.compare(readings[k : k + portion])
        standstill.learn(repeats, len(repeats.count))
        found.append(repeats.count)
    return np.vstack(found)


@pytest.mark.parametrize("step_C", [0.001, 0.25, 1.0])
def test_a_coarse_sensor_is_not_stuck(step_C):
    """A reading that drifts by 3 K, with noise of 10 mK, rounded."""
    dice = np.random.default_rng(3)
    values = np.linspace(20.0, 23.0, 4000) + 0.01 * dice.standard_normal(4000)
    assert repeats_of(np.round(values / step_C)[:, None] * step_C, 100).max() <= 10


def test_a_temperature_that_ran_by_many_steps_and_rests_within_one_is_not_stuck():
    """A heater that is on for a minute in ten; sixteenths of a kelvin, and no noise that shows."""
    on = np.arange(3000) % 200 < 20
    values = 25.0 + np.cumsum(np.where(on, 0.4, -0.4 * 20 / 180))
    values = np.append(values, np.full(400, values[-1] + 0.02))
    assert repeats_of(np.round(values / 0.0625)[:, None] * 0.0625, 100).max() == 0.0


@pytest.mark.parametrize("portion", [1, 7, 400])
def test_a_fine_sensor_counts_its_repeats_over_a_gap(portion):
    dice = np.random.default_rng(4)
    values = np.round(20 + 0.03 * dice.standard_normal((400, 2)), 2)
    values[300:, 0], values[310, 0] = 19.99, np.nan  # one reading missed says nothing
    values[299, 0] = 20.5
    found = repeats_of(values, portion)
    assert found[300:, 0].tolist() == [*range(10), 9, *range(10, 99)]
    assert found[:, 1].max() < 5


@pytest.mark.parametrize("each", [1, 3])
def test_a_length_counts_by_how_unlikely_its_repeats_are_beside_those_of_its_logger(each):
    """Readings that scatter by 0.2 um are told in 0.001 um, each so many times; then one of them lasts."""
    readings = np.repeat(np.round(np.random.default_rng(5).normal(0.0, 0.2, 60), 3), each)
    readings = np.append(readings, np.full(40, readings[-1]))[:, None]
    standstill = Standstill(np.zeros(1, dtype=bool))
    count = standstill.compare(readings).count[:, 0]
    assert count[: 60 * each].max() == 0.0
    (first, *_) = np.flatnonzero(count >= 20.0)
    assert 3 <= first - (60 * each - 1) <= 12 * each


def test_what_a_mean_is_rounded_by_is_no_resolution():
    """The means of two sides may differ in the last digit only; one repeat, later, is chance."""
    readings = np.round(np.random.default_rng(6).normal(50.0, 0.1, 300), 3)
    readings[101], readings[201] = readings[100] * (1.0 + 4e-16), readings[200]
    assert readings[101] != readings[100]
    assert Standstill(np.zeros(1, dtype=bool)).compare(readings[:, None]).count.max() < STILL
