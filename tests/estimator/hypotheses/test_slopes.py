"""Slopes of a model's own parameters are kept at a few points, and are those of the model at that point."""

from itertools import pairwise

import numpy as np
import pytest

from estimator.batch.trials import slow_trials_of
from estimator.effects import CATALOGUE
from estimator.hypotheses.candidates import candidates
from estimator.hypotheses.ground import of_tables
from estimator.hypotheses.hypothesis import DONE, refined
from estimator.hypotheses.panel import Panel
from estimator.hypotheses.slopes import POINTS, Column, slopes_beside, slopes_of
from estimator.work import Runs
from tests.estimator.conftest import with_effect

PATHS = ["still_air.h", "nut_friction.power"]


@pytest.fixture
def trials(plain, bar, lives):
    return slow_trials_of(plain, Runs(bar, lives(with_effect(plain, "churning", share=0.3))[:2]))


def test_slopes_beside_a_candidate_are_those_of_the_model_without_it(plain, bar, trials):
    wide, _ = candidates(plain, bar, [CATALOGUE["churning"]])
    (trial, *_), columns = trials, [Column(wide, path) for path in (PATHS[0], "churning.share", PATHS[1])]
    fresh = slopes_of(trial, trial.pose(wide), columns)
    for _ in range(2):  # the second time they are the kept ones
        beside = slopes_beside(plain, trial, trial.pose(wide), columns)
        for one, other in zip(beside, fresh, strict=True):
            np.testing.assert_allclose(one.reading, other.reading, rtol=1e-9, atol=1e-12)
            np.testing.assert_allclose(one.length, other.length, rtol=1e-9, atol=1e-12)


def test_a_trial_keeps_slopes_at_a_few_points_only_and_never_of_another_point(plain, trials):
    trial, *_ = trials
    found = []
    for h in np.linspace(5.0, 9.0, POINTS + 2):
        model = plain.with_values({"still_air.h": float(h)})
        found.append(slopes_beside(model, trial, trial.pose(model), [Column(model, PATHS[1])])[0].reading)
    assert len(trial.slopes) == POINTS
    assert all(np.nanmax(abs(one - other)) > 0 for one, other in pairwise(found))


def test_a_fit_with_kept_slopes_ends_where_fresh_slopes_promise_nothing_more(plain, bar, trials):
    ground, (churning,) = of_tables(plain), candidates(plain, bar, [CATALOGUE["churning"]])[1]
    h = refined(ground, trials, [churning])
    known, true = ground.belief(h.model, h.paths), with_effect(plain, "churning", share=0.3)
    fresh, planted = (Panel.of(trials, m, [Column(m, p) for p in h.paths], known) for m in (h.model, true))
    assert 0.0 <= fresh.promise < DONE
    assert fresh.cost < planted.cost
    assert fresh.cost < 0.1 * Panel.of(trials, plain, []).cost
    assert h.misfit == pytest.approx(fresh.judge().misfit, rel=1e-9)
