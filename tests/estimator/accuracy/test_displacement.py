"""What a reading of the displacement has beside growth, and the level of many."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.accuracy.displacement import EDGE_S, jig_doubt, jig_expansion, levels
from estimator.model import Value, model_of


@pytest.fixture
def run(rig, driven):
    """30 s with a probe that warms by 0.1 K/s."""
    recording = driven(rig, 30, (4, 24))
    recording.inputs["probe"][:] = 22 + np.linspace(0, 2.9, 30)
    return recording


def test_a_warm_probe_adds_and_a_warm_bar_takes_away(run, full):
    values = full.with_values({"displacement.probe": 0.2, "displacement.bar": 0.5})
    np.testing.assert_allclose(jig_expansion(run, values), 0.02 * np.arange(30), atol=1e-9)
    run.inputs["bar"][:] = 22 + 0.1 * np.arange(30)
    np.testing.assert_allclose(jig_expansion(run, values), -0.03 * np.arange(30), atol=1e-9)


def test_without_probe_and_bar_nothing_is_corrected(run, full):
    assert (jig_expansion(run, model_of([])) == 0).all()
    bare = replace(run, inputs={})
    assert (jig_expansion(bare, full) == 0).all()
    assert (jig_doubt(bare, full, 1.0) == 0).all()


def test_coefficients_are_known_as_well_as_the_model_says(run, full):
    known = full.with_values({"displacement.probe": Value(0.3, sd=0.1), "displacement.bar": Value(0.4, sd=0.2)})
    np.testing.assert_allclose(jig_doubt(run, known, 11.0), 0.01 * np.abs(np.arange(30) - 10), atol=1e-9)
    run.inputs["bar"][:] = run.inputs["probe"]
    np.testing.assert_allclose(jig_doubt(run, known, 1.0), np.hypot(0.01, 0.02) * np.arange(30), atol=1e-9)
    assert (jig_doubt(run, full, 1.0) == 0).all()  # of what is not fitted nothing is known, as the filter takes it


@pytest.mark.parametrize("many", [None, 3])
def test_a_level_is_a_line_through_half_a_minute_on_each_side(many):
    dice = np.random.default_rng(1)
    time_s = 40000.0 + np.cumsum(dice.uniform(0.5, 9.0, 60))
    reading = dice.standard_normal((60, many) if many else 60) + 300.0
    at_s = np.array([time_s[0], time_s[20], time_s[-1] + 3.0])
    found, noise = levels(time_s, reading, at_s)
    for at, um, share in zip(at_s, found, noise, strict=True):
        near = np.abs(time_s - at) <= EDGE_S
        np.testing.assert_allclose(um, np.polyfit(time_s[near] - at, reading[near], 1)[-1], atol=1e-6)
        weights = np.linalg.pinv(np.vander(time_s[near] - at, 2))[-1]
        assert share == pytest.approx(weights @ weights, rel=1e-6)


def test_where_there_are_few_readings_the_nearest_counts():
    found, noise = levels(np.array([0.0, 50.0, 55.0]), np.array([1.0, 2.0, 4.0]), np.array([10.0, 52.0, 53.0, 99.0]))
    np.testing.assert_allclose(found, [1.0, 2.0, 4.0, 4.0])
    np.testing.assert_allclose(noise, 1.0)
    one, _ = levels(np.array([7.0]), np.array([3.0]), np.array([0.0, 9.0]))
    np.testing.assert_allclose(one, 3.0)
