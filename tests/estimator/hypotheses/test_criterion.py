"""When a hypothesis counts."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from estimator.accuracy.noise_floor import Error
from estimator.hypotheses.criterion import clearly, most, proven, worth
from estimator.hypotheses.panel import Explanation


def explanation(misfit: float, fitted: float, parameters: int = 0) -> Explanation:
    """Of two recordings, a hundred independent readings."""
    nothing = np.zeros(0)
    return Explanation(
        tuple(range(parameters)), nothing, np.zeros((0, 0)), misfit, 100.0, Error(misfit, misfit), misfit,
        np.full(2, misfit), np.full((2, 2, 1), misfit / 8), fitted,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("parameters", "fitted", "is_proven"), [(1, 0.76, True), (1, 0.78, False), (3, 0.73, True), (3, 0.75, False)]
)
def test_what_only_foretells_runs_left_out_better_is_not_proven(parameters, fitted, is_proven):
    """100 ln(0.8 / x) > 3.84 for one parameter more, 7.81 for three: x < 0.770, 0.740."""
    before, after = explanation(1.3, 0.8), explanation(1.0, fitted, parameters)
    assert clearly(before, after, 100)
    assert proven(before, after, 100) == is_proven


def test_what_foretells_runs_left_out_no_better_is_not_proven():
    assert not proven(explanation(1.3, 0.8), explanation(1.2, 0.4, 1), 100)


def test_most_of_a_misfit_is_half_of_it():
    assert most(explanation(100.0, 0.8), explanation(49.0, 0.4))
    assert not most(explanation(100.0, 0.8), explanation(51.0, 0.4))


@pytest.mark.parametrize(
    ("grown_um", "read_um", "is_worth"), [(0.2, 0.12, True), (0.38, 0.12, False), (0.2, float("nan"), False)]
)
def test_readings_of_drives_are_worth_what_the_rests_lose_with_them(grown_um, read_um, is_worth):
    """Temperatures as they were; what is read while driving falls by more than is seen at the table, or is not read."""
    before = replace(explanation(1.0, 0.8), error=Error(0.05, 0.25), read_um=0.18)
    after = replace(before, error=Error(0.05, grown_um), read_um=read_um)
    assert worth(SimpleNamespace(judged=after, at_bound=list), before) == is_worth
