"""The score against the complex step of a likelihood that shares with it the terms only, and against differences."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch import batch
from estimator.batch.trial import Trial
from estimator.effect import Effect, Param
from estimator.model import Model, model_of
from estimator.rig import Rig
from estimator.sensitivity.score import score
from estimator.sensitivity.tangent import tangent
from estimator.terms import SCREW, Heat
from tests.conftest import SMALL, SMALL_VALUES
from tests.estimator.sensitivity.plain import likelihood

TICKS = 120
STEP = 1e-30
NOISE = {"noise", "sd", "lag_noise", "zero_sd", "zero_walk", "gain_sd", "lag_sd"}
LEVELS = [f"{e.name}.{key}" for e in SMALL for key in e.params if key in NOISE]
IDLE = {"thermometers.gain_sd", "thermometers.lag_sd"}  # considered, but never estimated


# --- on the small rig, every level


MADE = {**SMALL_VALUES, "displacement.zero_sd": 2.0, "thermometers.board": 0.004, "thermometers.zero_sd": 0.05}
OTHER = {
    "nut_friction.power": 75.0, "nut_friction.n": 1.2, "thermometers.tau": 6.0, "thermometers.sd": 0.03,
    "nut_body.g": 3.0, "conduction.noise": 2.0, "expansion_error.error": 0.02,
}  # fmt: skip


def recorded(rig: Rig, model: Model, driven, live):
    """Drive and rest with gaps, silent ticks and late readings; everything around becomes warmer, each at its pace."""
    drive = driven(rig, TICKS * rig.tick_s, (15 * rig.tick_s, 80 * rig.tick_s), stroke=(0.0, 100.0))
    for i, name in enumerate(("ambient", "nut", "probe", "bar", "board"), start=1):
        drive.inputs[name][:] = 22 + i / 60 * np.arange(TICKS)
    run = live(model, rig, drive, seed=3, process=True).recording
    dice = np.random.default_rng(0)
    run.channels[1:][dice.random((TICKS - 1, len(rig.names))) < 0.3] = np.nan
    run.channels[0, 2] = run.channels[40:43] = np.nan
    return replace(run, ages_s=dice.uniform(0, 0.9, run.channels.shape))


@pytest.fixture(scope="module")
def made() -> Model:
    """Every effect of the catalogue that the small rig can serve."""
    return model_of(SMALL, "small").with_values(MADE)


@pytest.fixture(scope="module")
def trial(half, made, driven, live) -> Trial:
    """At two ticks a second: a tick that is forgotten shows."""
    return Trial(made, half, recorded(half, made, driven, live))


@pytest.fixture(scope="module")
def there(made) -> Model:
    """Not the model that the trial was made with: its lags stay those of the other."""
    return made.with_values(OTHER)


@pytest.fixture(scope="module")
def found(trial, there) -> tuple[float, dict[str, float]]:
    value, slopes = score(trial, there, LEVELS)
    return value, dict(zip(LEVELS, slopes, strict=True))


def slope(trial: Trial, model: Model, path: str, made_with: Model) -> float:
    """Derivative of the independent likelihood."""
    return likelihood(trial, model.with_values({path: model[path] + STEP * 1j}), made_with).imag / STEP


def test_the_recording_has_regimes_gaps_lags_and_late_readings(trial, there):
    posed = trial.pose(there)
    assert len(posed.system.F) > 3
    assert 0.3 < np.isnan(posed.system.y).mean() < 0.7
    assert not trial.muted.any()
    assert abs(posed.run.lag[:, :4]).max() > 0.5
    assert abs(posed.run.late).max() > 0.05
    assert abs(posed.run.grown).max() > 5


def test_the_value_is_the_likelihood(trial, there, made, found):
    value, _ = found
    assert value == pytest.approx(trial.loglike(there), rel=1e-9)
    assert value == pytest.approx(batch.loglike(trial.pose(there).system), rel=1e-9)
    assert value == pytest.approx(likelihood(trial, there, made).real, rel=1e-9)


@pytest.mark.parametrize("path", LEVELS)
def test_the_score_is_the_complex_step_of_an_independent_likelihood(path, trial, there, made, found):
    true = slope(trial, there, path, made)
    assert (true != 0) == (path not in IDLE)
    assert found[1][path] == pytest.approx(true, rel=1e-6)


def test_each_score_is_the_same_alone(trial, there, found):
    for path in ("thermometers.zero_sd", "nut_body.noise", "displacement.sd"):
        assert score(trial, there, [path])[1] == pytest.approx([found[1][path]], rel=1e-9)


def test_without_an_expansion_error_and_with_zeros_that_are_known(small, made, driven, live):
    """Other states: no unknown zeros but the displacement's, a coefficient that is exact; and a longer tick."""
    exact = replace(small, tick_s=2.0, screw=replace(small.screw, expansion_tolerance=0.0))
    known = (made - "expansion_error").with_values({"thermometers.zero_sd": 0.0})
    trial = Trial(known, exact, recorded(exact, known, driven, live))
    for path in ("nut_friction.noise", "thermometers.lag_noise", "thermometers.sd", "displacement.zero_walk"):
        true = slope(trial, known, path, known)
        assert score(trial, known, [path])[1] == pytest.approx([true], rel=1e-6), path


class Rub(Effect):
    """Something rubs while the screw turns, unevenly."""

    power = Param(20.0, "W", lo=0.0, null=0.0)
    noise = Param(0.2, "sqrt(s)", lo=0.0, hi=10.0)

    def terms(self, p, u, rig):
        q = p.power * (u.omega > 0)
        yield Heat(SCREW, q, over=np.exp(-0.5 * ((rig.screw.x_mm - 70.0) / 20) ** 2) / 5, noise=p.noise * q)


def test_a_users_own_effect_gets_its_score(small, made, driven, live):
    model = made + Rub
    trial = Trial(model, small, recorded(small, model, driven, live))
    true = slope(trial, model, "rub.noise", model)
    assert true != 0.0
    assert score(trial, model, ["rub.noise"])[1] == pytest.approx([true], rel=1e-6)


# --- on the paper's rig


@pytest.fixture(scope="module")
def paper(rig, full, driven, live) -> Trial:
    drive = driven(rig, 200, (20, 120))
    for i, name in enumerate((name for name in rig.inputs if name != "position"), start=1):
        drive.inputs[name][:] = 22 + i / 200 * np.arange(200)
    return Trial(full, rig, live(full, rig, drive, seed=4, process=True).recording)


@pytest.mark.parametrize(
    ("path", "step"),
    [("conduction.noise", 0.02), ("thermometers.sd", 2e-4), ("nut_body.noise", 0.05), ("displacement.zero_sd", 0.02)],
)
def test_the_score_on_the_paper_s_rig_is_that_of_differences(path, step, paper, full):
    def at(steps: int) -> float:
        return paper.loglike(full.with_values({path: full[path] + steps * step}))

    fourth_order = (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * step)
    assert score(paper, full, [path])[1][0] == pytest.approx(fourth_order, rel=1e-4)


def test_noise_levels_do_not_move_the_mean_and_all_others_do(paper, full):
    posed = paper.pose(full)
    moving = {path for path in full.values if tangent(paper, posed, full, path).moves_mean}
    assert moving == {path for path in full.values if path.partition(".")[2] not in NOISE}


def test_what_has_no_influence_moves_nothing(rig, full, driven, live):
    """At rest friction does nothing, and a board as warm as it was shifts no thermometer."""
    rest = Trial(full, rig, live(full, rig, driven(rig, 30, (30, 30)), seed=1).recording)
    paths = ["nut_friction.power", "nut_friction.noise", "thermometers.board", "displacement.bar"]
    assert score(rest, full, paths[1:2])[1] == pytest.approx([0.0], abs=1e-12)
    assert not any(tangent(rest, rest.pose(full), full, path).moves_mean for path in paths)
