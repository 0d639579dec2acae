"""When a hypothesis counts."""

import numpy as np
import pytest

from estimator.accuracy.noise_floor import Error
from estimator.hypotheses.criterion import clearly, proven
from estimator.hypotheses.panel import Explanation


def explanation(misfit: float, fitted: float) -> Explanation:
    """Of two recordings, a hundred independent readings."""
    nothing = np.zeros(0)
    return Explanation(
        (), nothing, np.zeros((0, 0)), misfit, 100.0, Error(misfit, misfit), misfit, np.full(2, misfit),
        np.full((2, 2, 1), misfit / 8), fitted,
    )  # fmt: skip


@pytest.mark.parametrize(("fitted", "is_proven"), [(0.6, True), (0.68, True), (0.72, False), (0.8, False)])
def test_what_only_foretells_runs_left_out_better_is_not_proven(fitted, is_proven):
    """100 / 2 ln(0.8 / x) > ln(100 / 0.05): x < 0.687."""
    before, after = explanation(1.3, 0.8), explanation(1.0, fitted)
    assert clearly(before, after, 100)
    assert proven(before, after, 100) == is_proven


def test_what_foretells_runs_left_out_no_better_is_not_proven():
    assert not proven(explanation(1.3, 0.8), explanation(1.2, 0.4), 100)
