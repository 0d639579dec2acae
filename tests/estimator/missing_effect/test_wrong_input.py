"""A run whose input is wrong is named, on recordings that a model has lived."""

from __future__ import annotations

import numpy as np
import pytest

from estimator.batch.trials import slow_trials_of
from estimator.effects import CATALOGUE
from estimator.hypotheses.ground import Ground
from estimator.missing_effect.odd_run import odd_run
from estimator.missing_effect.suggest import suggest
from estimator.missing_effect.wrong_input import ZERO, corrected
from estimator.work import Runs


@pytest.mark.parametrize("wrong", ["speed", "speed and position"])
def test_a_wrong_label_names_run_and_signal(wrong, plain, bar, lives):
    runs = lives(plain)[:3]
    runs[1] = corrected(runs[1], bar, wrong, -np.log(1.2))
    found = suggest(plain, Runs(bar, runs), CATALOGUE.values())
    assert found.verdict == "input_error"
    assert (found.wrong_input.run, found.wrong_input.signal) == ("run 1", wrong)
    assert found.wrong_input.ratio == pytest.approx(1.2, abs=0.04)


def test_one_run_with_another_zero_of_the_position_is_named_with_its_size(plain, bar, lives):
    runs = lives(plain)
    runs[2] = corrected(runs[2], bar, ZERO, -30.0)
    found = suggest(plain, Runs(bar, runs), CATALOGUE.values())
    assert (found.verdict, found.wrong_input.run, found.wrong_input.signal) == ("input_error", "run 2", "position")
    assert found.wrong_input.shift_mm == pytest.approx(30.0, abs=5.0)


def test_no_run_is_odd_where_all_fit_alike(plain, bar, lives):
    runs = lives(plain)
    assert odd_run(Ground(plain, ()), slow_trials_of(plain, Runs(bar, runs))) is None
