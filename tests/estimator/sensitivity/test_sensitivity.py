"""Columns of sensitivities against refits and differences; their Gram matrix against the exact score."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from estimator.batch import batch
from estimator.batch.trial import Posed, Trial
from estimator.effect import Effect, Param
from estimator.model import Model, model_of
from estimator.record import Array
from estimator.rig import Rig
from estimator.sensitivity.score import score
from estimator.sensitivity.sensitivity import columns, information, nominal_column
from estimator.sensitivity.tangent import tangent
from estimator.terms import SCREW, Heat
from tests.conftest import SMALL, SMALL_VALUES

PARAMETERS = [f"{e.name}.{key}" for e in SMALL for key, param in e.params.items() if param.over != "channel"]
QUIET = {f"{name}.noise": 0.0 for name in ("nut_friction", "anchor_friction", "free_friction")}
POWERS = [
    f"{name}_friction.{key}"
    for name, key in (
        ("nut", "power"), ("nut", "power_nut"), ("anchor", "power"), ("anchor", "power_housing"), ("free", "power"),
    )
]  # fmt: skip


class Lamp(Effect):
    """A lamp warms the near end with the air's temperature rise.

    q = P (T_air - 22)
    """

    power = Param(3.0, "W/K", lo=0.0, null=0.0)

    def terms(self, p, u, rig):
        yield Heat(SCREW, p.power * u.rise("ambient") / 5, over=rig.screw.x_mm < rig.screw.from_mm + 50)


def exact(rig: Rig) -> Rig:
    """The rig with a coefficient of expansion that is known: what the model alone grows then moves no variance."""
    return replace(rig, screw=replace(rig.screw, expansion_tolerance=0.0))


def recorded(model: Model, rig: Rig, driven, live, ticks: int, stroke: tuple[float, float]) -> Trial:
    """Drive and rest with gaps and late readings, everything around becoming warmer at its own pace."""
    drive = driven(rig, ticks * rig.tick_s, (10 * rig.tick_s, ticks // 2 * rig.tick_s), stroke=stroke)
    for i, name in enumerate((name for name in rig.inputs if name != "position"), start=1):
        drive.inputs[name][:] = 22 + i / ticks * np.arange(ticks)
    run = live(model, rig, drive, seed=3, process=True).recording
    dice = np.random.default_rng(0)
    run.channels[1:][dice.random((ticks - 1, len(rig.names))) < 0.3] = np.nan
    return Trial(model, rig, replace(run, ages_s=dice.uniform(0, 0.9, run.channels.shape)))


@pytest.fixture(scope="module")
def small_trial(half, driven, live) -> tuple[Trial, Model]:
    """The small rig at half a second, with every effect that fits it."""
    values = {**SMALL_VALUES, "displacement.zero_sd": 2.0, "thermometers.board": 0.004}
    model = model_of(SMALL, "small").with_values(values)
    return recorded(model, half, driven, live, 120, (0.0, 100.0)), model


@pytest.fixture(scope="module")
def linear(rig, full, driven, live) -> tuple[Trial, Model]:
    """The paper's rig with all that makes a heat's power act on the mean alone, and linearly."""
    model = (full + Lamp).with_values(QUIET)
    return recorded(model, exact(rig), driven, live, 200, (0.0, 400.0)), model


# --- linear in the heat: everything is exact


def test_the_slope_of_a_power_is_its_exact_score(linear):
    trial, model = linear
    paths = [*POWERS, "lamp.power"]
    (whole,) = information(trial, model, paths, 1e9)
    np.testing.assert_allclose(whole[:-1, -1], score(trial, model, paths)[1], rtol=1e-8)


@pytest.mark.parametrize("path", [*POWERS, "lamp.power"])
def test_another_power_changes_the_likelihood_as_its_column_says(path, linear):
    """loglike(p + dp) = loglike(p) + g dp - G dp^2 / 2."""
    trial, model = linear
    (whole,) = information(trial, model, [path], 1e9)
    for step in (-0.3, 4.0):
        gained = trial.loglike(model.with_values({path: model[path] + step})) - trial.loglike(model)
        assert gained == pytest.approx(whole[0, 1] * step - 0.5 * whole[0, 0] * step**2, rel=1e-8)


def test_several_powers_at_once_change_it_by_the_whole_matrix(linear):
    trial, model = linear
    (whole,) = information(trial, model, POWERS, 1e9)
    step = np.array([3.0, -2.0, 1.0, 4.0, -1.5])
    moved = model.with_values({path: model[path] + d for path, d in zip(POWERS, step, strict=True)})
    gained = trial.loglike(moved) - trial.loglike(model)
    assert gained == pytest.approx(step @ whole[:-1, -1] - 0.5 * step @ whole[:-1, :-1] @ step, rel=1e-8)


def test_scatter_in_proportion_to_a_power_tells_of_the_power_too(linear):
    """It is in the score, and not in the columns."""
    trial, model = linear
    noisy = model.with_values({"nut_friction.noise": 3.0})
    (whole,) = information(trial, noisy, POWERS[:1], 1e9)
    assert abs(score(trial, noisy, POWERS[:1])[1][0] / whole[0, 1] - 1) > 1e-3


def test_blocks_of_time_sum_up_to_the_whole(linear):
    trial, model = linear
    parts = information(trial, model, POWERS[:2], 60.0)
    (whole,) = information(trial, model, POWERS[:2], 1e9)
    assert parts.shape == (4, 3, 3)
    np.testing.assert_allclose(parts.sum(axis=0), whole, rtol=1e-9)
    np.testing.assert_allclose(parts, parts.transpose(0, 2, 1), rtol=0)
    short = Trial(model, trial.rig, trial.recording.rows(slice(0, 61)))  # 60 ticks after the first
    np.testing.assert_allclose(parts[0], information(short, model, POWERS[:2], 1e9)[0], rtol=1e-9)


# --- every parameter, against differences


def step_of(model: Model, path: str) -> float:
    """Its fourth power, what the differences err by, is below what is allowed; a shorter one would show rounding."""
    return 1e-2 * (abs(model[path]) or 1.0)


def difference(quantity: Callable[[Model], Array], model: Model, path: str) -> Array:
    """Derivative of a quantity of the model with respect to a parameter, of fourth order."""
    step = step_of(model, path)
    one, two, less, lesser = (quantity(model.with_values({path: model[path] + k * step})) for k in (1, 2, -1, -2))
    return (8 * (one - less) - (two - lesser)) / (12 * step)


def alone(trial: Trial, model: Model) -> Array:
    """What the channels read by the model alone, (T, m), their zeros as the first sample told them."""
    posed = trial.pose(model)
    run, zeros = posed.run, posed.state.channel_zeros(posed.system.x0)
    return posed.offset[1:] + run.lagged + run.late + zeros


# Each tick rounds a state of 22 degC by an eps or two for each of its modes, and each processor in its own way: in a
# run that is up to 20 ticks x 22 K x eps (a quarter of it was seen on four processors), divided by the step. Where a
# parameter hardly acts, as rotating_convection.m here, no difference tells more: 1e-4 of the derivative.
ROUNDING = 20 * 120 * 22 * np.finfo(float).eps


def alike(found: Array, differences: Array, model: Model, path: str) -> None:
    """Equal to 1e-6 of the largest, but for the rounding of the differences."""
    allowed = 1e-6 * np.abs(differences).max() + ROUNDING / step_of(model, path)
    np.testing.assert_allclose(found, differences, rtol=0, atol=allowed)


@pytest.mark.parametrize("path", PARAMETERS)
def test_the_open_loop_reading_moves_as_differences_say(path, small_trial):
    trial, model = small_trial
    posed = trial.pose(model)
    column = nominal_column(trial, posed, tangent(trial, posed, model, path))
    alike(column.reading, difference(lambda m: alone(trial, m), model, path), model, path)
    alike(column.grown, difference(lambda m: trial.pose(m).run.grown, model, path), model, path)


@pytest.mark.parametrize("path", ["anchor_housing.g_base", "anchor_housing.capacity", "free_friction.n"])
def test_it_does_so_on_the_paper_s_rig(path, linear):
    trial, model = linear
    posed = trial.pose(model)
    column = nominal_column(trial, posed, tangent(trial, posed, model, path))
    moved = difference(lambda m: alone(trial, m), model, path)
    assert abs(moved).max() * model[path] > 1e-3
    alike(column.reading, moved, model, path)


def test_noise_moves_the_open_loop_run_through_the_first_estimate_only(small_trial):
    trial, model = small_trial
    posed = trial.pose(model)
    for path, moves in (("thermometers.sd", True), ("thermometers.zero_sd", True), ("conduction.noise", False)):
        moved = tangent(trial, posed, model, path)
        assert not moved.moves_mean
        reading = nominal_column(trial, posed, moved).reading
        assert (abs(reading).max() > 1e-3) == moves, path


def test_columns_are_how_the_linear_system_moves(small_trial):
    """B = dF x + db;   D = dH x_predicted - dy, the gains held."""
    trial, model = small_trial
    posed = trial.pose(model)
    paths = [path for path in model.values if tangent(trial, posed, model, path).moves_mean]
    assert len(paths) > 12
    system, d = posed.system, posed.system.F.shape[1]
    x = np.vstack([system.x0, *(chunk.x for chunk in batch.passes(system))])
    predicted = system.b + x[:-1]
    predicted[:, :d] += np.einsum("tij,tj->ti", system.F[system.regime] - np.eye(d), x[:-1, :d])
    read = np.isfinite(system.y)

    def states(model: Model) -> Array:
        there = trial.pose(model).system
        moved = there.b.copy()
        moved[:, :d] += np.einsum("tij,tj->ti", there.F[there.regime], x[:-1, :d])
        return moved[:, :d]

    def readings(model: Model) -> Array:
        there = trial.pose(model).system
        grown = predicted[:, there.column] * there.grown
        return (predicted @ there.H.T + grown[:, None] * there.spans - there.y)[read]

    found = columns(trial, posed, model, paths)
    for i, path in enumerate(paths):
        B, D, start = (part[..., i] for part in found)
        alike(B, difference(states, model, path), model, path)
        alike(D[read], difference(readings, model, path), model, path)
        alike(start, difference(lambda m: trial.pose(m).system.x0, model, path), model, path)


def test_no_parameters_leave_the_data_alone(small_trial):
    trial, model = small_trial
    posed: Posed = trial.pose(model)
    (whole,) = information(trial, model, [], 1e9)
    nis = np.concatenate([chunk.nis for chunk in batch.passes(posed.system)])
    assert whole.shape == (1, 1)
    assert whole[0, 0] == pytest.approx(np.nansum(nis), rel=1e-9)
