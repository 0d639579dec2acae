"""What is known of parameters beforehand: distances from it are white."""

import numpy as np
import pytest

from estimator.sensitivity.prior import belief

PATHS = ("nut_body.capacity", "nut_friction.power", "nut_friction.n")


def test_of_tables_each_by_itself(full):
    found = belief(full, PATHS, ())
    middle, root = found.middle, found.root
    params = [full.param(path) for path in PATHS]
    assert list(middle) == [p.value for p in params]
    np.testing.assert_allclose(root, np.diag([1 / p.sd for p in params]))


def test_of_an_earlier_fit_with_its_correlations_and_of_tables_for_the_rest(full):
    """Sizes from a hundredth to thousands."""
    rho, sd = np.array([[1.0, -0.9], [-0.9, 1.0]]), np.array([60.0, 0.004])
    covariance = rho * np.outer(sd, sd)
    model = full.with_values({"nut_body.capacity": 1218.0}).known((PATHS[0], PATHS[2]), covariance)
    known = belief(model, PATHS, PATHS)
    middle, root = known.middle, known.root
    assert list(middle) == [1218.0, full.param(PATHS[1]).value, 1.0]
    found = np.linalg.inv(root.T @ root)
    np.testing.assert_allclose(found[np.ix_([0, 2], [0, 2])], covariance, rtol=1e-6)
    assert found[1, 1] == pytest.approx(full.param(PATHS[1]).sd ** 2)
    assert not found[1, [0, 2]].any()


def test_an_earlier_fit_counts_only_where_it_is_asked_for(full):
    model = full.known(PATHS[:1], np.array([[1.0]]))
    assert belief(model, PATHS, ()).root[0, 0] == pytest.approx(1 / full.param(PATHS[0]).sd)
