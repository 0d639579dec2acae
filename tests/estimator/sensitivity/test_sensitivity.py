"""How the open-loop run moves with each parameter, against differences."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.trial import Trial
from estimator.effect import Effect, Param
from estimator.model import Model, model_of
from estimator.record import Array
from estimator.rig import Rig
from estimator.sensitivity.sensitivity import nominal_columns
from estimator.sensitivity.tangent import tangent
from estimator.terms import SCREW, Heat
from tests.conftest import SMALL, SMALL_VALUES

PARAMETERS = [f"{e.name}.{key}" for e in SMALL for key, param in e.params.items() if param.over != "channel"]
QUIET = {f"{name}.noise": 0.0 for name in ("nut_friction", "anchor_friction", "free_friction")}


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
    (column,) = nominal_columns(posed, [tangent(trial, posed, model, path)])
    alike(column.reading, difference(lambda m: alone(trial, m), model, path), model, path)
    alike(column.grown, difference(lambda m: trial.pose(m).run.grown, model, path), model, path)


@pytest.mark.parametrize("path", ["anchor_housing.g_base", "anchor_housing.capacity", "free_friction.n"])
def test_it_does_so_on_the_paper_s_rig(path, linear):
    trial, model = linear
    posed = trial.pose(model)
    (column,) = nominal_columns(posed, [tangent(trial, posed, model, path)])
    moved = difference(lambda m: alone(trial, m), model, path)
    assert abs(moved).max() * model[path] > 1e-3
    alike(column.reading, moved, model, path)


def test_noise_moves_the_open_loop_run_through_the_first_estimate_only(small_trial):
    trial, model = small_trial
    posed = trial.pose(model)
    for path, moves in (("thermometers.sd", True), ("thermometers.zero_sd", True), ("conduction.noise", False)):
        moved = tangent(trial, posed, model, path)
        assert not moved.moves_mean
        reading = next(nominal_columns(posed, [moved])).reading
        assert (abs(reading).max() > 1e-3) == moves, path
