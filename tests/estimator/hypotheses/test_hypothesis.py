"""Steps of a fit in full: where heat grows without bound there is none."""

import numpy as np
import pytest

from estimator.batch.trials import slow_trials_of
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.hypothesis import _panel, _step
from estimator.inputs.follower import TEMPERATURE, all_followers
from estimator.unknown.stand_ins import UnknownHeat
from estimator.work import Runs


@pytest.mark.parametrize("far", [-1e4, -1e9])
def test_a_step_to_where_heat_grows_without_bound_is_not_taken(far, plain, bar, lives):
    """The warmer a place is, the more heat it gets, soon or at once. Warnings are errors here: nothing is said."""
    power, follows = "unknown_heat.power", all_followers(bar).index(TEMPERATURE)
    model = (plain + UnknownHeat).with_values({power: 0.0, "unknown_heat.follows": follows, "unknown_heat.at": 100.0})
    trials, known = slow_trials_of(model, Runs(bar, lives(plain)[:1])), Ground(model, (power,)).belief(model, [power])

    def seen(there):
        away = there if there is model else there.with_values({power: far})
        return _panel(trials, (power,), known, model, away)

    assert not np.isfinite(seen(model.with_values({power: 0.1})).cost)
    assert _step(model, seen(model), seen, bar)[0] is model
