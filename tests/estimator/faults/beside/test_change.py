"""What thermometers leave unexplained: against the conditional normal distribution, written out."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from estimator.faults.beside import change as module
from estimator.faults.beside.change import AS_IT_IS, SCALES, Unexplained, unexplained
from estimator.faults.beside.windows import FEWEST

X = np.arange(15) * 62.0
ALIKE = np.exp(-0.5 * ((X[:, None] - X) / 250.0) ** 2)
SCATTER = 25.0 + 0.005**2 * np.eye(15)


def test_what_the_others_say_is_the_conditional_mean():
    """c_i given the rest: C_ir C_rr^-1 c_r, with variance C_ii - C_ir C_rr^-1 C_ri."""
    dice = np.random.default_rng(0)
    model, change = 0.03**2 * ALIKE, dice.normal(size=15)
    C, found = model + SCATTER, unexplained(change, model, SCATTER, AS_IT_IS)
    for i in range(15):
        rest = np.arange(15) != i
        weights = np.linalg.solve(C[np.ix_(rest, rest)], C[rest, i])
        assert found.value[i] == pytest.approx(change[i] - weights @ change[rest], rel=1e-6)
        assert found.sd[i] == pytest.approx(np.sqrt(C[i, i] - weights @ C[rest, i]), rel=1e-6)


@pytest.mark.parametrize("times", [1.0, 10.0, 60.0])
def test_a_model_that_is_worse_than_it_says_is_seen_to_be(times):
    """By a factor, and whatever the one does that is judged."""
    dice, doubts, found = np.random.default_rng(1), 0.02 * np.sin(np.outer(X, np.arange(1, 13) / 100.0)), []
    for _ in range(30):
        change = times * doubts @ dice.normal(size=12) + dice.normal(0.0, 0.005, 15)
        change[4] += 50.0
        found.append(unexplained(change, doubts @ doubts.T, SCATTER).scale[4])
    assert np.median(found) == pytest.approx(times, rel=0.4)


@given(st.lists(st.booleans(), min_size=15, max_size=15), st.integers(0, 14), st.floats(-5.0, 5.0))
def test_the_one_outlier_is_the_one_that_is_off_by_most_sd(read, wrong, size):
    """Whatever the others have in common, and whichever of them are read."""
    at = np.flatnonzero(np.array(read) | (np.arange(15) == wrong))
    if abs(size) < 0.5 or len(at) < FEWEST:
        return
    change = np.full(15, 3.0)
    change[wrong] += size
    model = 0.01**2 * ALIKE + 0.003**2 * np.eye(15)
    some = np.ix_(at, at)
    assert at[unexplained(change[at], model[some], SCATTER[some], SCALES).furthest] == wrong


@pytest.mark.parametrize(
    ("share", "sd", "heat", "none"),
    [(0.05, 0.1, True, False), (0.05, 0.3, False, False), (-0.5, 0.34, False, False), (0.97, 0.1, False, True)],
)
def test_what_the_others_cannot_tell_is_neither_heat_nor_none(share, sd, heat, none):
    """Not by overshooting either: where heat would hardly reach the others, their noise seems to show twice as much."""
    nothing = Unexplained(*np.zeros((3, 1)))
    tested = module.Tested(0.5, 0.03, 1.0, np.array([[share], [sd]]), np.array([1]), nothing)
    assert (tested.is_heat, tested.not_heat > 1.0) == (heat, none)
