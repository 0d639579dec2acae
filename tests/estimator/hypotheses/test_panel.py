"""Moments and panel: what others predict of a recording left out, against least squares written out."""

from typing import NamedTuple

import numpy as np
import pytest

from estimator.batch.trials import slow_trials_of
from estimator.effects import CATALOGUE
from estimator.hypotheses.candidates import candidates
from estimator.hypotheses.moments import moments
from estimator.hypotheses.panel import Panel
from estimator.hypotheses.slopes import Column
from estimator.work import Runs
from tests.estimator.conftest import with_effect


class Explained(NamedTuple):
    """As much of an explanation as values are made of."""

    chosen: tuple[int, ...]
    change: np.ndarray


@pytest.fixture(scope="module")
def panel(plain, bar, lives) -> Panel:
    wide, found = candidates(plain, bar, [CATALOGUE["churning"], CATALOGUE["sensor_lag"]])
    runs = lives(with_effect(plain, "churning", share=0.1))
    paths = ["still_air.h", "nut_friction.power", *(path for c in found for path in c.paths)]
    columns = [Column(wide, path) for path in paths]
    return Panel(columns, moments(slow_trials_of(wide, Runs(bar, runs)), wide, columns))


def prior_of(panel: Panel) -> np.ndarray:
    """1 / sd^2 of each parameter; all are at their table values, or have none."""
    sds = [column.model.param(column.path).sd for column in panel.columns]
    return np.array([1.0 / sd**2 if sd else 0.0 for sd in sds])


def test_left_out_misfit_is_what_the_others_predict(panel):
    """Against least squares, priors and products written out."""
    chosen = [0, 1, 2]
    prior = prior_of(panel)[chosen]
    weighted = [m.weighted for m in panel.found]
    rests = []
    for out in range(len(weighted)):
        sums = sum(w for i, w in enumerate(weighted) if i != out)
        change = np.linalg.solve(sums[np.ix_(chosen, chosen)] + np.diag(prior), sums[chosen, -1])
        d = np.append(-change, 1.0)
        at = [*chosen, -1]
        rests.append(d @ weighted[out][np.ix_(at, at)] @ d)
    judged = panel.judge(chosen)
    unlikely = judged.change**2 @ prior
    assert judged.misfit == pytest.approx((sum(rests) + unlikely) / sum(m.weight for m in panel.found), rel=1e-5)
    assert judged.runs.sum() == pytest.approx(
        sum(r / m.weight for r, m in zip(rests, panel.found, strict=True)), rel=1e-5
    )


def test_readings_say_as_much_less_of_a_value_as_they_are_off_more(panel):
    """A^-1 (few S + P) A^-1 with few the mean square that is left, as in a fit."""
    chosen, whole = [0, 1], sum(m.weighted for m in panel.found)
    S, P, judged = whole[np.ix_(chosen, chosen)], np.diag(prior_of(panel)[chosen]), panel.judge(chosen)
    d = np.append(-judged.change, 1.0)
    few = d @ whole[np.ix_([*chosen, -1], [*chosen, -1])] @ d / sum(m.weight for m in panel.found)
    assert 0.25 < few < 0.8
    bread = np.linalg.inv(S + P)
    np.testing.assert_allclose(judged.covariance, bread @ (few * S + P) @ bread, rtol=1e-5)


def test_gains_are_what_a_fit_takes_off(panel):
    whole, prior = sum(m.weighted for m in panel.found), prior_of(panel)
    for beside in ([], [0, 1]):
        gains = panel.gains(beside)
        for k in (2, 3):
            solved = {}
            for chosen in (beside, [*beside, k]):
                change = panel.judge(chosen).change
                d, at = np.append(-change, 1.0), [*chosen, -1]
                solved[len(chosen)] = d @ whole[np.ix_(at, at)] @ d + change**2 @ prior[chosen]
            taken = solved[len(beside)] - solved[len(beside) + 1]
            assert gains[k] == pytest.approx(taken, rel=1e-4, abs=1e-6)


def test_a_change_stays_inside_its_bounds(panel):
    judged = panel.judge([3])  # a lag cannot be negative
    assert panel.at[3] + judged.change[0] >= -1e-9


def test_a_value_at_its_bound_is_there_to_the_last_digit(panel):
    """0.1 + 0.2 - 0.3 is not 0: a conductance of -3e-17 W/K would be refused."""
    down = Explained(chosen=(0,), change=np.array([0.0 - panel.at[0]]) * (1.0 + 1e-15))
    assert panel.values(down) == {"still_air.h": 0.0}


def test_what_nothing_tells_of_is_known_to_no_sd(plain, bar, lives):
    """Where heat of no power sits."""
    wide, _ = candidates(plain, bar, [CATALOGUE["local_heat"]])
    columns = [Column(wide, "local_heat.at")]
    trials = slow_trials_of(wide, Runs(bar, lives(plain)[:1]))
    assert Panel(columns, moments(trials, wide, columns)).judge().sd == [np.inf]
