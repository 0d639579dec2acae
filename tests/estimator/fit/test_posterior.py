"""The log posterior as a search sees it, and the way up to its maximum."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import product
from unittest import mock

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimator.batch.trial import Trial
from estimator.batch.trials import Trials
from estimator.effect import Effect, Param
from estimator.fit.fit import fit
from estimator.fit.optimiser import ENOUGH, Optimiser, bounded_step, corrected, positive
from estimator.fit.posterior import Coordinate, Posterior
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.sensitivity import information
from estimator.terms import Heat
from estimator.work import Runs

TRUE = {"nut_friction.power": 75.0, "nut_body.g": 3.0, "thermometers.sd": 0.04}
FREE = [*TRUE, "displacement.sd", "displacement.probe", "conduction.noise"]

# --- coordinates

WIDE = Param(0.3, "W", lo=0.01, hi=100.0)


def coordinate(value: float, param: Param = WIDE, noise: bool = False) -> Coordinate:
    return Coordinate("effect.param", param, value, noise)


@given(theta=st.floats(0.01, 100.0), size=st.floats(0.1, 10.0), noise=st.booleans())
def test_a_coordinate_goes_there_and_back(theta, size, noise):
    seen = coordinate(size, noise=noise)
    c = seen.of(theta)
    assert seen.value(c) == pytest.approx(theta, rel=1e-12)
    assert seen.bounds[0] <= c <= seen.bounds[1]
    assert seen.slope(c) * 1e-6 == pytest.approx((seen.value(c + 5e-7) - seen.value(c - 5e-7)), rel=1e-4) or not (
        seen.bounds[0] + 1e-6 < c < seen.bounds[1] - 1e-6
    )


def test_a_noise_level_is_seen_by_its_logarithm_and_all_else_by_its_size():
    assert coordinate(2.0, noise=True).of(0.5 * np.e) - coordinate(2.0, noise=True).of(0.5) == pytest.approx(1.0)
    assert coordinate(2.0).of(5.0) == 2.5


def test_a_coordinate_beyond_its_bounds_is_the_parameter_at_them():
    for noise in (False, True):
        lo, hi = coordinate(2.0, noise=noise).bounds
        found = [coordinate(2.0, noise=noise).value(c) for c in (lo - 1, lo, hi, hi + 1)]
        assert found == pytest.approx([0.01, 0.01, 100, 100])


def test_a_noise_level_that_may_be_zero_has_a_logarithm_all_the_same():
    seen = coordinate(1.0, Param(0.3, "W", lo=0.0, hi=10.0), noise=True)
    assert seen.of(0.0) == seen.bounds[0] == pytest.approx(np.log(1e-5))


def test_a_noise_level_without_an_upper_bound_has_a_logarithm():
    seen = coordinate(1.0, Param(0.3, "W", lo=0.0), noise=True)
    assert seen.value(seen.of(0.3)) == pytest.approx(0.3)


# --- the posterior


@pytest.fixture(scope="module")
def model(small_model) -> Model:
    """Its thermometers do not lag: in a life with scattering heat they do not either."""
    return small_model.with_values({"thermometers.tau": 0.0})


@pytest.fixture(scope="module")
def drive(small, driven):
    def make(seconds: int, until: int):
        drive = driven(small, seconds, (10, until), stroke=(0.0, 100.0))
        drive.inputs["probe"][:] = 22 + np.linspace(0, 2, seconds)
        return drive

    return make


@pytest.fixture(scope="module")
def trials(small, model, drive, live) -> list[Trial]:
    """Two recordings of a rig that is not as the model says."""
    true = model.with_values(TRUE)
    runs = [live(true, small, drive(n, n // 2), seed, process=True).recording for seed, n in ((1, 200), (2, 150))]
    return [Trial(model, small, run) for run in runs]


@pytest.fixture(scope="module")
def posterior(model, trials) -> Posterior:
    return Posterior(model, Trials(trials), FREE)


def difference(f: Callable[[Array], float | Array], c: Array, i: int, step: float) -> float | Array:
    """Derivative with respect to coordinate i, of fourth order."""
    way = step * np.eye(len(c))[i]
    return (8 * (f(c + way) - f(c - way)) - (f(c + 2 * way) - f(c - 2 * way))) / (12 * step)


def test_it_starts_at_the_model_and_knows_its_noise_levels(posterior, model):
    assert list(posterior.noise) == [path.endswith(("sd", "noise")) for path in FREE]
    at = posterior.at(posterior.start)
    assert [at[path] for path in FREE] == pytest.approx([model[path] for path in FREE])
    assert posterior.start[FREE.index("nut_body.g")] == 1.0


def test_the_value_is_the_sum_of_likelihoods_and_priors(posterior, model, trials):
    """probe has 0.3 +- 0.3; the others have no prior."""
    c = posterior.start.copy()
    c[FREE.index("displacement.probe")] *= 3.0
    moved = model.with_values({"displacement.probe": 0.9})
    assert posterior.value(c) == pytest.approx(sum(trial.loglike(moved) for trial in trials) - 0.5 * 2.0**2, rel=1e-12)


def test_the_slope_is_the_derivative_of_the_value(posterior):
    """With noise levels, and with a prior where it pulls."""
    for c in (posterior.start, posterior.start + 0.1 * np.arange(1, len(FREE) + 1)):
        value, slope = posterior.slope(c)
        assert value == pytest.approx(posterior.value(c), rel=1e-12)
        differences = [difference(posterior.value, c, i, 2e-3) for i in range(len(c))]
        np.testing.assert_allclose(slope, differences, rtol=1e-5, atol=1e-4)


def test_a_prior_pulls_back_with_its_width(model, trials):
    """All else is the readings': the same recordings under a prior and without one."""
    paths = ["displacement.probe"]
    posterior = Posterior(model, Trials(trials), paths)
    free = replace(posterior.coordinates[0], param=replace(posterior.coordinates[0].param, sd=None))
    c = np.array([2.5])
    with_it = posterior.slope(c)[1], posterior.information(c).whole
    posterior.coordinates = [free]
    without = posterior.slope(c)[1], posterior.information(c).whole
    assert with_it[0] - without[0] == pytest.approx([-0.3 * (2.5 * 0.3 - 0.3) / 0.3**2], rel=1e-6)
    assert with_it[1] - without[1] == pytest.approx(np.array([[1.0]]), rel=1e-6)


def test_the_information_on_the_mean_is_that_of_the_columns(posterior, model, trials):
    found = posterior.information(posterior.start)
    np.testing.assert_allclose(found.whole, found.whole.T)
    mean = np.flatnonzero(~posterior.noise)
    paths = [FREE[i] for i in mean]
    size = np.array([model[path] for path in paths])
    gram = sum(information(trial, model, paths, 1e9)[0] for trial in trials)
    np.testing.assert_allclose(found.data[np.ix_(mean, mean)], gram[:-1, :-1] * np.outer(size, size), rtol=1e-9)
    assert list(np.flatnonzero(found.prior)) == [FREE.index("displacement.probe")]


def test_the_information_of_noise_levels_is_the_curvature_of_the_value(posterior):
    c = posterior.start
    found = posterior.information(c)
    for i in np.flatnonzero(posterior.noise):
        curvature = -np.asarray(difference(lambda c: posterior.slope(c)[1], c, i, 5e-3))
        np.testing.assert_allclose(found.whole[i], curvature, rtol=0.1, atol=0.02 * abs(curvature).max())


def test_a_prior_on_a_noise_level_is_no_information_of_the_data(model, trials):
    """At the prior's own middle it adds its width, and nothing to the rest."""
    posterior = Posterior(model, Trials(trials), ["thermometers.sd"])
    (seen,) = posterior.coordinates
    without = posterior.information(posterior.start)
    posterior.coordinates = [replace(seen, param=replace(seen.param, sd=0.0002))]
    found = posterior.information(posterior.start)
    assert found.prior == pytest.approx([(0.022 / 0.0002) ** 2])
    assert found.prior[0] > 0.5 * without.data[0, 0]
    assert found.data == pytest.approx(without.data, rel=0.1)


def test_blocks_are_the_slopes_of_ten_minutes_each_and_without_noise_levels(small, model, driven, live):
    """Of a recording of 25 min, where nothing but heat is unknown: their sum is the slope."""
    exact = replace(small, screw=replace(small.screw, expansion_tolerance=0.0))
    quiet = model.with_values({"nut_friction.noise": 0.0})
    drive = driven(exact, 1501, (10, 1300), stroke=(0.0, 100.0))
    run = live(quiet, exact, drive, 1, process=True).recording
    posterior = Posterior(quiet, Trials([Trial(quiet, exact, run)] * 2), ["nut_friction.power", "thermometers.sd"])
    found = posterior.information(posterior.start)
    assert found.blocks.shape == (6, 2)
    np.testing.assert_array_equal(found.blocks[:3], found.blocks[3:])
    assert not found.blocks[:, 1].any()
    assert found.blocks[:, 0].sum() == pytest.approx(posterior.slope(posterior.start)[1][0], rel=1e-8)


def test_recordings_side_by_side_give_the_same(posterior, model, trials):
    with ThreadPoolExecutor(2) as pool:
        shared = Posterior(model, Trials(trials, pool.map), FREE)
        np.testing.assert_array_equal(shared.slope(posterior.start)[1], posterior.slope(posterior.start)[1])


def test_a_power_is_no_noise_level_because_the_first_recording_rests(small, model, trials, drive, live):
    rest = Trial(model, small, live(model, small, drive(60, 10), seed=3).recording)
    assert not Posterior(model, Trials([rest, trials[0]]), ["nut_friction.power"]).noise.any()


class Draught(Effect):
    """Something cools or warms the nut as the probe warms up: q = a (T_probe - T_probe(0))."""

    a = Param(0.0, "W/K", lo=-5.0, hi=5.0, null=0.0)

    def terms(self, p, u, rig):
        yield Heat("nut", p.a * u.rise("probe"))


def test_a_parameter_without_influence_stays_at_zero(small, model, driven, live):
    model = model + Draught
    steady = driven(small, 60, (10, 40), stroke=(0.0, 100.0))
    trial = Trial(model, small, live(model, small, steady, seed=1).recording)
    posterior = Posterior(model, Trials([trial]), ["draught.a"])
    assert posterior.at(posterior.start)["draught.a"] == 0.0


def test_a_zero_that_is_known_may_be_free(small, model, trials):
    """Its sd is 0 and stays there: no likelihood has a slope at an sd of nothing."""
    known = model.with_values({"thermometers.zero_sd": 0.0})
    posterior = Posterior(
        known, Trials([Trial(known, small, trials[0].recording)]), ["thermometers.zero_sd", "nut_body.g"]
    )
    slope, alone = posterior.slope(posterior.start)[1], Posterior(known, posterior.trials, ["nut_body.g"])
    assert slope == pytest.approx([0.0, alone.slope(alone.start)[1][0]], rel=1e-9)


def test_the_information_of_a_noise_level_at_its_upper_bound(model, trials):
    def information_at(sd: float) -> float:
        posterior = Posterior(model.with_values({"thermometers.sd": sd}), Trials(trials), ["thermometers.sd"])
        return float(posterior.information(posterior.start).data[0, 0])

    assert information_at(0.5) == pytest.approx(information_at(0.48), rel=0.2)


# --- the optimiser


@pytest.fixture(scope="module")
def top(posterior) -> Optimiser:
    optimiser = Optimiser(posterior)
    optimiser.run()
    return optimiser


@pytest.fixture(scope="module")
def summit(top, model, trials) -> float:
    """The highest there is: of a second optimiser from where the first one ended."""
    again = Optimiser(Posterior(top.posterior.at(top.c), Trials(trials), FREE))
    again.run()
    return again.value


def left(optimiser: Optimiser) -> float:
    """What a step by the information at the optimiser's end would gain."""
    slope = optimiser.posterior.slope(optimiser.c)[1]
    return float(0.5 * slope @ np.linalg.solve(positive(optimiser.posterior.information(optimiser.c).whole), slope))


def test_a_climb_ends_inside_the_bounds_where_the_slope_is_next_to_nothing(top, posterior):
    assert top.converged
    assert not top.stopped
    assert (top.c > posterior.bounds[0]).all()
    assert (top.c < posterior.bounds[1]).all()
    value, slope = posterior.slope(top.c)
    assert value == pytest.approx(top.value, rel=1e-12)
    assert np.linalg.norm(slope) < 0.01 * np.linalg.norm(posterior.slope(posterior.start)[1])
    information = posterior.information(top.c).whole
    assert (np.linalg.eigvalsh(information) > 0).all()
    assert left(top) < 4 * ENOUGH


def test_it_ends_higher_than_the_truth_and_not_far_from_it(summit, top, posterior, model):
    true = model.with_values(TRUE)
    c = np.array([seen.of(true[seen.path]) for seen in posterior.coordinates])
    assert 0 < 2 * (summit - posterior.value(c)) < 20  # a chi square of 6
    found = posterior.at(top.c)
    for path in TRUE:
        assert found[path] == pytest.approx(TRUE[path], rel=0.1), path


def test_every_step_is_heard_and_higher_than_the_one_before(posterior, top):
    heard = []
    optimiser = Optimiser(posterior, lambda n, value: heard.append((n, value)))
    optimiser.run()
    steps, values = zip(*heard, strict=True)
    assert list(steps) == list(range(1, optimiser.steps + 1))
    assert (np.diff([optimiser.first, *values]) > 0).all()
    assert values[-1] == optimiser.value == top.value


@pytest.mark.parametrize(
    "bad",
    [
        {"nut_body.g": 10.0},
        {"thermometers.sd": 0.4},
        {"displacement.sd": 4.0},
        {"conduction.noise": 80.0, "nut_friction.power": 250.0, "displacement.probe": 1.9},
        {"thermometers.sd": 0.005},
        {"conduction.noise": 0.03},
    ],
    ids=lambda bad: ", ".join(f"{path} {value}" for path, value in bad.items()),
)
def test_it_climbs_there_from_a_bad_start(bad, model, trials, summit):
    optimiser = Optimiser(Posterior(model.with_values(bad), Trials(trials), FREE))
    optimiser.run()
    assert optimiser.converged
    assert optimiser.first < summit - 20
    assert summit - optimiser.value < 6 * ENOUGH
    assert left(optimiser) < 6 * ENOUGH


def test_it_stops_at_a_bound_and_never_leaves_them(small, model, drive, live):
    hot = live(model.with_values({"nut_friction.power": 380.0}), small, drive(200, 100), seed=1).recording
    posterior = Posterior(model, Trials([Trial(model, small, hot)]), ["nut_friction.power", "thermometers.tau"])
    seen, at = [], posterior.at
    with mock.patch.object(posterior, "at", lambda c: seen.append(c.copy()) or at(c)):
        optimiser = Optimiser(posterior)
        optimiser.run()
    lo, hi = posterior.bounds
    assert (np.array(seen) > lo - 1e-9).all()
    assert (np.array(seen) < hi + 1e-9).all()
    assert optimiser.converged
    assert at(optimiser.c)["nut_friction.power"] == pytest.approx(300.0, abs=1e-6)
    assert posterior.slope(optimiser.c)[1][0] > 1  # higher still, but for the bound


def test_ctrl_c_between_steps_leaves_the_best_so_far(posterior, top):
    def interrupt(n: int, value: float) -> None:
        if n == 2:
            raise KeyboardInterrupt

    optimiser = Optimiser(posterior, interrupt)
    optimiser.run()
    assert optimiser.stopped
    assert not optimiser.converged
    assert optimiser.steps == 2
    assert optimiser.first < optimiser.value < top.value
    assert optimiser.value == posterior.value(optimiser.c)


def test_ctrl_c_within_a_step_leaves_the_one_before(model, trials):
    posterior = Posterior(model, Trials(trials), FREE)
    optimiser, real = Optimiser(posterior), posterior.slope

    def interrupted(c: Array) -> tuple[float, Array]:
        if optimiser.steps == 2:
            raise KeyboardInterrupt
        return real(c)

    with mock.patch.object(posterior, "slope", interrupted):
        optimiser.run()
    assert optimiser.stopped
    assert optimiser.steps == 2
    assert optimiser.first < optimiser.value == posterior.value(optimiser.c)


def test_ctrl_c_in_the_second_search_of_a_fit_is_told(small, model, trials):
    searches = []

    def interrupt(stage: str, n: float) -> None:
        if stage.startswith("likelihood, run 1:"):
            searches.append(n)
            if len(searches) == 2:
                raise KeyboardInterrupt

    free = {path: replace(value, fixed=path not in FREE) for path, value in model.values.items()}
    found = fit(model.with_values(free), Runs(small, [trials[1].recording], progress=interrupt))
    assert len(searches) == 2
    assert found.stopped


# --- its parts

SIZES = st.integers(1, 3)
SEEDS = st.integers(0, 10**6)


def curved(dice: np.random.Generator, p: int) -> Array:
    """A curvature of directions that are up to a thousand times stiffer than others."""
    root = dice.standard_normal((p, p + 2)) * 10 ** dice.uniform(-1.5, 1.5, (p, 1))
    return root @ root.T


def best_by_trying(C: Array, g: Array, lo: Array, hi: Array) -> float:
    """The most that g s - s C s / 2 can be: of all sets of coordinates held at a bound."""
    best = -np.inf
    for held in product((None, 0, 1), repeat=len(g)):
        if any(which is not None and np.isinf((lo, hi)[which][i]) for i, which in enumerate(held)):
            continue
        s = np.array([0.0 if which is None else (lo, hi)[which][i] for i, which in enumerate(held)])
        free = [i for i, which in enumerate(held) if which is None]
        s[free] = np.linalg.solve(C[np.ix_(free, free)], (g - C @ s)[free])
        if (s >= lo - 1e-9).all() and (s <= hi + 1e-9).all():
            best = max(best, g @ s - 0.5 * s @ C @ s)
    return best


@given(p=SIZES, seed=SEEDS)
def test_a_bounded_step_is_the_best_there_is(p, seed):
    dice = np.random.default_rng(seed)
    C, g, c = curved(dice, p), 3 * dice.standard_normal(p), dice.standard_normal(p)
    lo, hi = c - dice.exponential(1.0, p), c + dice.exponential(1.0, p)
    lo[dice.random(p) < 0.2], hi[dice.random(p) < 0.2] = -np.inf, np.inf
    at = dice.random(p) < 0.2
    c[at] = np.where(np.isfinite(lo), lo, c)[at]
    s = bounded_step(C, g, c, (lo, hi))
    assert (c + s >= lo - 1e-9).all()
    assert (c + s <= hi + 1e-9).all()
    best = best_by_trying(C, g, lo - c, hi - c)
    assert g @ s - 0.5 * s @ C @ s == pytest.approx(best, rel=1e-6, abs=1e-9)


@given(p=SIZES, seed=SEEDS)
def test_a_corrected_curvature_is_positive_and_fits_the_change_of_slope(p, seed):
    """Where the slope fell too little along the step, a part of what was expected is put in its place."""
    dice = np.random.default_rng(seed)
    C, step = curved(dice, p), dice.standard_normal(p)
    change = dice.uniform(-1, 3) * C @ step + 0.1 * dice.standard_normal(p)
    found = corrected(C, step, change)
    np.testing.assert_allclose(found, found.T, rtol=1e-9, atol=1e-9 * abs(found).max())
    assert np.linalg.eigvalsh(found).min() > 0
    promised = step @ C @ step
    if step @ change >= 0.2 * promised:
        np.testing.assert_allclose(found @ step, change, rtol=1e-6, atol=1e-8 * abs(found).max())
    else:
        assert step @ found @ step == pytest.approx(0.2 * promised, rel=1e-6)


@given(p=SIZES, seed=SEEDS)
@settings(max_examples=50)
def test_positive_leaves_what_is_positive_and_turns_what_is_not(p, seed):
    dice = np.random.default_rng(seed)
    C = curved(dice, p)
    np.testing.assert_allclose(positive(C), C, rtol=1e-9, atol=1e-9 * abs(C).max())
    np.testing.assert_allclose(positive(-C), C, rtol=1e-9, atol=1e-9 * abs(C).max())
    mixed = C - dice.uniform(0, 2) * np.diag(np.diag(C)) * np.sign(dice.standard_normal(p))
    assert np.isfinite(np.linalg.cholesky(positive(mixed))).all()


def test_positive_gives_a_direction_without_curvature_a_little():
    found = positive(np.array([[4.0, 0.0], [0.0, 0.0]]))
    np.testing.assert_allclose(found, [[4.0, 0.0], [0.0, 0.0]], atol=1e-12)
    assert found[1, 1] > 0
