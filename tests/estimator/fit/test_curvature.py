"""Steps of a search: by how misfits move, and by how they did not."""

import numpy as np
import pytest
import scipy

from estimator.fit.curvature import Curvature

DICE = np.random.default_rng(4)
J, F = DICE.standard_normal((9, 3)) * [1.0, 30.0, 0.01], DICE.standard_normal(9)
ROOM = np.array([[-np.inf] * 3, [np.inf] * 3])


def test_of_linear_misfits_the_first_step_is_the_last():
    step, gain = Curvature(3).step(J.T @ F, J.T @ J, ROOM)
    assert J.T @ (F + J @ step) == pytest.approx(0.0, abs=1e-9)
    assert gain == pytest.approx(F @ F - np.sum((F + J @ step) ** 2))


def test_a_step_ends_at_a_bound_and_the_others_make_the_best_of_it():
    room = np.array([[-0.1, -1.0, -5.0], [0.1, 1.0, 5.0]])
    step, _ = Curvature(3).step(J.T @ F, J.T @ J, room)
    np.testing.assert_allclose(step, scipy.optimize.lsq_linear(J, -F, room, method="bvls").x, rtol=1e-6)


def test_the_next_step_knows_by_how_much_the_last_one_changed_the_slope():
    curvature, there = Curvature(3), np.array([0.3, -0.02, 4.0])
    before, after = J.T @ F, J.T @ F + J.T @ J @ there + [5.0, 0.0, 0.4]  # a bend on the way
    curvature.learn(there, before, J.T @ J, after)
    np.testing.assert_allclose(curvature.step(before - after, J.T @ J, ROOM)[0], there, rtol=1e-6)
