"""Tuning finds the noise of simulated recordings, touches nothing else, and says when noise stands in for physics."""

from dataclasses import replace
from types import SimpleNamespace
from unittest import mock

import numpy as np
import pytest

from estimator.accuracy.noise_floor import Error, missing_physics, noise_floor
from estimator.batch.coarse import coarse
from estimator.batch.trial import Trial
from estimator.batch.trials import Trials
from estimator.effect import Effect, Param
from estimator.errors import SetupError
from estimator.fit.noise import noise_levels
from estimator.fit.tune import Factors, Tuned, scaled, tune
from estimator.model import Model, model_of
from estimator.terms import Read, Store
from estimator.work import Runs

TICK_S = 5
MEASUREMENT = {"thermometers.sd": 0.022, "displacement.sd": 0.15}
PROCESS = {"conduction.noise": 1.2, "nut_friction.noise": 0.3, "nut_body.noise": 5.0}
OFF = {path: 2.0 * value for path, value in MEASUREMENT.items()} | {path: value / 5 for path, value in PROCESS.items()}


@pytest.fixture(scope="module")
def model(small_model) -> Model:
    """What a life with scattering heat can show: no lags, zeros that stay."""
    still = {"thermometers.tau": 0.0, "thermometers.zero_walk": 0.0, "displacement.zero_walk": 0.0}
    return small_model.with_values({**still, "displacement.zero_sd": 100.0})


@pytest.fixture(scope="module")
def driving(small, driven):
    """A rig with a long tick and an exact coefficient, and a drive of 50 min."""
    exact = replace(small, screw=replace(small.screw, expansion_tolerance=0.0))
    return coarse(driven(exact, 3000, (50, 2000), stroke=(0.0, 100.0)), exact, TICK_S)


@pytest.fixture(scope="module")
def runs(model, driving, live) -> list:
    """Recordings that the model lived."""
    drive, rig = driving
    return [live(model, rig, drive, seed=seed, process=True).recording for seed in range(5)]


@pytest.fixture(scope="module")
def heard() -> list:
    return []


@pytest.fixture(scope="module")
def tuned(model, driving, runs, heard) -> Tuned:
    """From twice the measurement noise and a fifth of the process noise."""
    return tune(model.with_values(OFF), Runs(driving[1], runs, progress=lambda *told: heard.append(told)))


def test_the_scatter_of_thermometers_is_found(tuned):
    assert tuned.model["thermometers.sd"] == pytest.approx(0.022, rel=0.03)


def test_the_scatter_of_the_displacement_is_found(tuned):
    assert tuned.model["displacement.sd"] == pytest.approx(0.15, rel=0.07)
    assert tuned.after[-1].nis == pytest.approx(1.0, abs=0.15)


def test_the_factor_of_the_process_noise_is_found_and_their_proportions_stay(tuned):
    """Four thermometers are too few to leave one out: the screw's own noise is one of all."""
    assert tuned.factors.places == 1.0
    assert 5 / 1.5 < tuned.factors.others < 5 * 1.5
    for path, true in PROCESS.items():
        assert tuned.model[path] == pytest.approx(tuned.factors.others * true / 5, rel=1e-9), path


def test_every_other_parameter_stays_as_it_was(tuned, model):
    before = model.with_values(OFF)
    for path, value in before.values.items():
        if path not in OFF:
            assert tuned.model.values[path] == value, path
    assert tuned.model.effects == before.effects
    assert tuned.model.about == before.about


def test_levels_say_before_and_after_and_what_they_are_of(tuned):
    assert {level.path: level.kind for level in tuned.levels} == {
        **dict.fromkeys(MEASUREMENT, "measurement"), **dict.fromkeys(PROCESS, "process"),
    }  # fmt: skip
    for level in tuned.levels:
        assert level.before == OFF[level.path]
        assert level.after == tuned.model[level.path]
        assert level.unit == tuned.model.param(level.path).unit


def test_quality_improves_to_what_honest_noise_has(tuned, driving):
    _, rig = driving
    assert [one.channel for one in tuned.before] == [one.channel for one in tuned.after] == list(rig.names)
    for before, after in zip(tuned.before, tuned.after, strict=True):
        if after.channel in rig.thermometers:
            assert abs(after.nis - 1) < 0.15, after.channel
            assert abs(after.nis - 1) < abs(before.nis - 1), after.channel
        assert before.readings == after.readings > 400
        assert after.blind_nis < 2
    assert max(one.blind_nis for one in tuned.before) > 5


def test_it_tells_what_it_does(heard):
    assert {stage.partition(",")[0] for stage, _ in heard} == {"measurement noise", "blind minutes"}
    assert [n for stage, n in heard if stage.startswith("blind minutes")][:3] == [1, 2, 3]
    assert np.isfinite([float(stage.rpartition(" ")[2]) for stage, _ in heard]).all()


def test_tuning_again_changes_next_to_nothing(tuned, driving, runs):
    again = tune(tuned.model, Runs(driving[1], runs))
    assert again.factors.others == pytest.approx(1.0, abs=0.05)
    for level in again.levels:
        assert level.after == pytest.approx(level.before, rel=0.05), level.path


def test_the_floor_is_scatter_and_unknown_zeros_of_the_thermometers(tuned):
    floor = tuned.floor
    zero = tuned.model["thermometers.zero_sd"]
    assert floor.temperature_K == pytest.approx(np.hypot(tuned.model["thermometers.sd"], zero))
    assert floor.elongation_um == pytest.approx(tuned.model["displacement.sd"])


def test_a_channel_that_no_effect_reads_has_no_floor(model, driving, runs):
    rig = driving[1]
    bare = model - "displacement"
    floor = noise_floor(bare, Trial(bare, rig, runs[0]))
    assert floor.temperature_K == pytest.approx(np.hypot(0.022, bare["thermometers.zero_sd"]))
    assert np.isnan(floor.elongation_um)


@pytest.mark.parametrize(
    ("peaks", "found"),
    [
        ([(-2.4, 30.0, 0.3), (0.1, 33.0, 0.3)], 0.1),  # the higher of two
        ([(-2.4, 36.0, 0.3), (0.1, 33.0, 0.3)], -2.3),
        ([(-2.0, 0.5, 3.0)], -0.05),  # nearly flat: near where it was
    ],
)
def test_the_highest_peak_counts_and_a_flat_likelihood_leaves_the_noise(peaks, found, model, driving, runs):
    path = "conduction.noise"

    def likely(trial: Trial, moved: Model) -> SimpleNamespace:
        at = np.log(moved[path] / model[path])
        return SimpleNamespace(error=[0.0], loglike=max(h * np.exp(-0.5 * ((at - m) / w) ** 2) for m, h, w in peaks))

    with mock.patch("estimator.fit.tune.blind", likely):
        _, factors = scaled(model, Trials([Trial(model, driving[1], runs[0])]), [path])
    assert np.log(factors.others) == pytest.approx(found, abs=0.15)


# --- noise that stands in for physics


@pytest.fixture(scope="module")
def steady(model, driving, live):
    """A recording without any scatter of heat: what a complete model leaves open loop is its sensors'."""
    drive, rig = driving
    return live(model, rig, drive, seed=9).recording


def test_an_effect_left_out_is_missed(model, driving, steady):
    found = tune(model - "nut_body", Runs(driving[1], [steady]))
    assert found.missing == pytest.approx(found.errors["open_loop"].temperature_K / found.floor.temperature_K)
    assert found.missing > 3
    assert found.factors.others > 3


def test_nothing_is_missed_of_a_complete_model(model, driving, steady):
    found = tune(model, Runs(driving[1], [steady]))
    assert np.isnan(found.missing)
    assert found.factors.others < 1


def test_missing_is_three_times_the_floor():
    floor = Error(0.1, 0.2)
    assert np.isnan(missing_physics(Error(0.29, 9.0), floor))
    assert missing_physics(Error(0.4, 0.0), floor) == pytest.approx(4.0)
    assert np.isnan(missing_physics(Error(float("nan"), 0.0), floor))


# --- which levels there are


def test_what_stands_for_constant_errors_of_sensors_is_no_noise_level(rig, full, driven, live):
    trial = Trial(full, rig, live(full, rig, driven(rig, 60, (10, 50)), seed=1).recording)
    assert noise_levels(full, Trials([trial])) == {
        "measurement": ["thermometers.sd", "displacement.sd"],
        "process": [path for path in full.values if path.endswith(".noise")],
    }


def test_a_noise_level_of_zero_stays_zero(model, driving, runs):
    quiet = model.with_values({"nut_friction.noise": 0.0})
    found = tune(quiet, Runs(driving[1], runs[:1]))
    assert found.model["nut_friction.noise"] == 0.0
    assert "nut_friction.noise" not in [level.path for level in found.levels]


def test_short_recordings_leave_the_process_noise_alone(model, driving, runs):
    rig = driving[1]
    short = runs[0].rows(slice(0, 100))
    found = tune(model.with_values({path: OFF[path] for path in MEASUREMENT}), Runs(rig, [short]))
    assert found.factors == Factors()
    assert found.model["conduction.noise"] == 1.2
    assert found.model["thermometers.sd"] == pytest.approx(0.022, rel=0.15)


def test_process_noise_stays_inside_its_bounds(model, driving, runs):
    """The nut's may not exceed 100 W/sqrt(Hz): the others go on without it."""
    rig = driving[1]
    high = model.with_values({"nut_body.noise": 60.0, "conduction.noise": 0.05, "nut_friction.noise": 0.01})
    better, factors = scaled(high, Trials([Trial(high, rig, runs[0])]), list(PROCESS))
    assert better["conduction.noise"] == pytest.approx(max(0.05 * factors.others, 0.01))
    assert better["nut_body.noise"] == pytest.approx(min(60.0 * factors.others, 100.0))


class Body(Effect):
    """A block in the air: C dT/dt = 0."""

    capacity = Param(100.0, "J/K", lo=1.0, hi=1000.0)

    def terms(self, p, u, rig):
        yield Store("nut", p.capacity, 0.1)


class Glass(Effect):
    """Two thermometers of known scatter: y = T."""

    def terms(self, p, u, rig):
        for name in ("T1", "T2"):
            yield Read(name, {"nut": 1.0}, 0.05)


def test_a_model_without_noise_levels_cannot_be_tuned(driving, runs):
    with pytest.raises(SetupError, match=r"^bare: no effect has a noise level; nothing to tune$"):
        tune(model_of([Body, Glass], "bare"), Runs(driving[1], runs[:1]))


def test_ctrl_c_ends_the_tuning(model, driving, runs):
    def interrupt(stage: str, n: float) -> None:
        if stage.partition(",")[0] == "measurement noise":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tune(model.with_values(OFF), Runs(driving[1], runs[:1], progress=interrupt))


def test_noise_is_not_lowered_where_errors_last(model, driving, runs):
    """Readings whose errors stay alike for half a minute are not as good as their scatter."""
    rig = driving[1]
    dice = np.random.default_rng(0)
    lasting = np.zeros((len(runs[0]), len(rig.names)))
    lasting[:, :4] = 0.06 * np.repeat(dice.standard_normal((len(runs[0]) // 6 + 1, 4)), 6, axis=0)[: len(runs[0])]
    off = model.with_values({"thermometers.sd": 0.1})
    spoilt = replace(runs[0], channels=runs[0].channels + lasting)
    assert tune(off, Runs(rig, [spoilt])).model["thermometers.sd"] == 0.1
    assert tune(off, Runs(rig, [runs[0]])).model["thermometers.sd"] == pytest.approx(0.022, rel=0.05)
