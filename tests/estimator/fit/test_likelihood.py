"""The most likely noise levels: their slope, their curvature, and the way to them."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from estimator.batch.trial import Trial
from estimator.batch.trials import Trials
from estimator.fit.likelihood import Likelihood, likely
from estimator.fit.noise import levels_in
from estimator.model import Model
from estimator.record import Array

TRUE = {"thermometers.sd": 0.04, "displacement.sd": 0.3}
FREE = [*TRUE, "conduction.noise"]


@pytest.fixture(scope="module")
def model(small_model) -> Model:
    """Its thermometers do not lag: in a life with scattering heat they do not either."""
    return small_model.with_values({"thermometers.tau": 0.0})


@pytest.fixture(scope="module")
def trials(small, model, driven, live) -> Trials:
    """Two recordings of a rig that is noisier than the model says."""
    true, drive = model.with_values(TRUE), driven(small, 200, (10, 100), stroke=(0.0, 100.0))
    runs = [live(true, small, drive, seed, process=True).recording for seed in (1, 2)]
    return Trials([Trial(model, small, run) for run in runs])


@pytest.fixture(scope="module")
def target(model, trials) -> Likelihood:
    return Likelihood(model, trials, FREE)


def difference(f, c: Array, i: int, step: float) -> Array:
    """Derivative with respect to coordinate i, of fourth order."""
    way = step * np.eye(len(c))[i]
    return (8 * (f(c + way) - f(c - way)) - (f(c + 2 * way) - f(c - 2 * way))) / (12 * step)


def test_it_starts_at_the_model(target, model):
    assert [target.at(target.start)[path] for path in FREE] == pytest.approx([model[path] for path in FREE])
    assert np.exp(target.bounds[0]) == pytest.approx([0.0005, 5.0])


def test_the_value_is_the_sum_of_likelihoods(target, model, trials):
    moved = model.with_values({"thermometers.sd": 0.022 * np.e})
    expected = sum(trial.loglike(moved) for trial in trials)
    assert target.slope(target.start + np.eye(3)[0])[0] == pytest.approx(expected, rel=1e-12)


def test_the_slope_is_the_derivative_of_the_value(target):
    for c in (target.start, target.start + np.array([0.1, 0.2, 0.3])):
        differences = [difference(lambda c: target.slope(c)[0], c, i, 2e-3) for i in range(len(c))]
        np.testing.assert_allclose(target.slope(c)[1], differences, rtol=1e-5, atol=1e-4)


def test_the_covariance_is_the_inverse_curvature(model, trials):
    best = likely(model, trials, FREE, "noise").model
    target = Likelihood(best, trials, FREE)
    curvature = -np.array([difference(lambda c: target.slope(c)[1], target.start, i, 5e-3) for i in range(3)])
    level = np.array([best[path] for path in FREE])
    np.testing.assert_allclose(
        np.sqrt(np.diag(target.covariance())), np.sqrt(np.diag(np.linalg.inv(curvature))) * level, rtol=0.05
    )


def test_a_level_at_its_upper_bound_has_a_covariance(model, trials):
    def variance(sd: float) -> float:
        return float(Likelihood(model.with_values({"thermometers.sd": sd}), trials, FREE[:1]).covariance()[0, 0])

    assert variance(5.0) == pytest.approx(variance(4.8), rel=0.3)


def test_recordings_side_by_side_give_the_same(target, model, trials):
    with ThreadPoolExecutor(2) as pool:
        shared = Likelihood(model, Trials(trials.trials, pool.map), FREE)
        np.testing.assert_array_equal(shared.slope(target.start)[1], target.slope(target.start)[1])


@pytest.mark.parametrize("start", [{}, {"thermometers.sd": 0.4}, {"displacement.sd": 4.0, "conduction.noise": 80.0}])
def test_the_true_levels_are_found_from_anywhere(start, model, trials):
    found = likely(model.with_values(start), trials, FREE, "noise")
    assert found.converged
    for path in TRUE:
        assert found.model[path] == pytest.approx(TRUE[path], rel=0.15), path
    top = Likelihood(found.model, trials, FREE)
    step = np.linalg.solve(_curvature(top), slope := top.slope(top.start)[1])
    assert 0.5 * slope @ step < 0.05
    assert {path: found.model[path] for path in model.values if path not in FREE} == {
        path: model[path] for path in model.values if path not in FREE
    }


def _curvature(target: Likelihood) -> Array:
    level = np.exp(target.start)
    return np.linalg.inv(target.covariance() / np.outer(level, level))


def test_it_stops_at_a_bound(model, small, driven, live):
    loud = model.with_values({"thermometers.sd": 5.0})
    run = live(loud.with_values({"thermometers.sd": 9.0}), small, driven(small, 100, (10, 50), stroke=(0.0, 100.0)), 1)
    found = likely(loud, Trials([Trial(loud, small, run.recording)]), ["thermometers.sd"], "noise")
    assert found.model["thermometers.sd"] == pytest.approx(5.0)


def test_ctrl_c_leaves_the_best_so_far(model, trials):
    heard = []

    def interrupt(stage: str, n: float) -> None:
        heard.append(float(stage.rpartition(" ")[2]))
        if n == 4:
            raise KeyboardInterrupt

    found = likely(model, trials, FREE, "noise", interrupt)
    assert found.stopped
    assert not found.converged
    top = Likelihood(found.model, trials, FREE)
    assert top.slope(top.start)[0] == pytest.approx(max(heard), abs=0.06)
    assert max(heard) > heard[0]


def test_levels_are_what_moves_no_prediction(small, model, trials, driven, live):
    levels = levels_in([*model.values], model, trials)
    assert {path.partition(".")[2] for path in levels} == {"sd", "noise", "zero_sd", "zero_walk", "lag_noise"}
    still = live(model, small, driven(small, 60, (10, 10), stroke=(0.0, 100.0))).recording
    assert not levels_in(["nut_friction.power"], model, Trials([Trial(model, small, still), trials[0]]))


def test_a_zero_that_is_known_may_be_free(small, model, trials):
    known = model.with_values({"thermometers.zero_sd": 0.0})
    own = Trials([Trial(known, small, trials[0].recording)])
    target = Likelihood(known, own, ["thermometers.zero_sd", "thermometers.sd"])
    assert np.isfinite(target.slope(target.start)[1]).all()


def test_a_prior_pulls_back_with_its_width(model, trials):
    target = Likelihood(model, trials, FREE[:1])
    c = target.start + 0.5
    without = target.slope(c)
    target._root = np.array([1 / 0.01])
    value, slope = target.slope(c)
    off = 0.022 * (np.exp(0.5) - 1) / 0.01
    assert value - without[0] == pytest.approx(-0.5 * off**2, rel=1e-6)
    assert slope - without[1] == pytest.approx([-off / 0.01 * 0.022 * np.exp(0.5)], rel=1e-6)
