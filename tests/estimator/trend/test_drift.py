"""A drift is told of values that change, at the right run, and rarely of values that do not."""

import numpy as np
import pytest

from estimator.trend import drift as module
from estimator.trend.course import Course
from estimator.trend.drift import FEWEST, drift, tellable

DAYS = 86400.0 * np.arange(24.0)


def course(value: np.ndarray, sd: np.ndarray | float = 1.0) -> Course:
    return Course("anchor_friction.power", "W", value, np.where(np.isfinite(value), sd, np.nan))


def scatter(seed: int, sd: np.ndarray | float = 1.0) -> np.ndarray:
    return 25.0 + sd * np.random.default_rng(seed).standard_normal(len(DAYS))


def test_of_values_that_do_not_change_chance_alone_tells_a_drift(monkeypatch):
    """Whatever the scatter is in their sd, which differ from run to run: one in twenty, give or take 2.6 sd."""
    monkeypatch.setattr(module, "ORDERS", 399)
    sd = np.where(np.arange(len(DAYS)) % 3 == 0, 3.0, 0.5)
    told = [drift(course(scatter(seed, 2.0 * sd), sd), DAYS, 1).p < 0.05 for seed in range(400)]
    assert np.mean(told) == pytest.approx(0.05, abs=2.6 * np.sqrt(0.05 * 0.95 / 400))


@pytest.mark.parametrize("first", [3, 12, 20])
def test_a_step_is_told_with_its_run_and_size(first):
    found = drift(course(scatter(2) + 5.0 * (np.arange(len(DAYS)) >= first)), DAYS, 20)
    assert found.shape == "step"
    assert abs(found.run - first) <= 1
    assert found.change == pytest.approx(5.0, abs=3 * found.sd)
    assert found.p < 0.05
    assert found.share == pytest.approx(0.2, abs=0.1)


def test_a_rise_is_told_with_its_beginning_and_what_a_run_does_not_know_is_left_out():
    value = scatter(3) + np.maximum(DAYS - DAYS[11], 0.0) / 86400.0
    value[[4, 17]] = np.nan
    found = drift(course(value), DAYS, 20)
    assert found.shape == "rise"
    assert found.run == pytest.approx(12, abs=3)
    assert found.change == pytest.approx(12.0, abs=3 * found.sd)
    assert found.p < 0.01


def test_too_few_runs_tell_nothing():
    value = np.full(len(DAYS), np.nan)
    value[: FEWEST - 1] = np.arange(FEWEST - 1.0)
    assert drift(course(value), DAYS, 1) is None


def test_values_all_alike_do_not_drift():
    assert drift(course(np.full(len(DAYS), 25.0)), DAYS, 1).p == 1.0


def test_runs_of_one_date_are_no_rise_of_no_length():
    days = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 4.0, 4.0]) * 86400.0
    found = drift(course(np.array([25.0, 25.1, 24.9, 25.0, 28.0, 28.1, 27.9, 28.0])), days, 1)
    assert (found.shape, found.run) == ("step", 4)


@pytest.mark.parametrize(("runs", "told"), [(6, set()), (7, {"rise"}), (12, {"rise"}), (16, {"rise", "step"})])
def test_few_runs_have_few_orders_and_of_many_parameters_tell_no_step(runs, told):
    """The paper's model leaves 35 open: 35 / 6! is no chance of one in twenty."""
    assert tellable(DAYS[:runs], 35, 0.05) == told
