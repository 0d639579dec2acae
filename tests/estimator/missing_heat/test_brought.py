"""What effects bring by place and time is the heat that their terms say."""

import numpy as np
import pytest

from estimator.batch.trial import Trial
from estimator.effect import Effect, Param
from estimator.missing_heat.brought import brought
from estimator.missing_heat.zones import zones
from estimator.terms import SCREW, Heat, Link, Store


class Rubbing(Effect):
    """Something rubs between 50 and 100 mm while the screw turns."""

    power = Param(4.0, "W")

    def terms(self, p, u, rig):
        yield Heat(SCREW, p.power * u.motion.turning, over=rig.screw.overlap(50.0, 100.0) / 5)


class Draught(Effect):
    """A draught takes heat to the air all along, and out of a cup that the screw warms."""

    g = Param(0.2, "W/K")

    def terms(self, p, u, rig):
        yield Store("cup", 500.0, 0.01)
        yield Link("cup", SCREW, 0.1, over=rig.screw.overlap(0.0, 50.0) / 5)
        yield Link(SCREW, "ambient", p.g / rig.screw.cells)
        yield Link("cup", "ambient", p.g)


@pytest.fixture(scope="module")
def posed(small, small_model, driven, live):
    model = small_model + Rubbing + Draught
    trial = Trial(model, small, live(model, small, driven(small, 300, (50, 200)), seed=3).recording)
    return trial, trial.pose(model)


def test_heat_is_where_and_when_it_is(posed):
    trial, run = posed
    places = zones(trial.rig, run.forcing.place)
    found = brought(["rubbing"], trial, run, places)
    assert found.shape == (len(trial.rest), len(places))
    driving = trial.rest.omega > 0
    lengths = np.array([zone.length_m for zone in places])
    np.testing.assert_allclose(found[driving] @ lengths, 4.0)
    assert not found[~driving].any()
    inside = np.array([50.0 <= zone.middle_mm <= 100.0 for zone in places])
    assert not found[:, ~inside].any()


def test_what_is_lost_hangs_on_the_temperature_of_the_model_alone(posed):
    trial, run = posed
    places = zones(trial.rig, run.forcing.place)
    found = brought(["draught"], trial, run, places)
    cells = run.run.z[1:] @ run.forcing.place.rows(SCREW).T
    cup = run.run.z[1:] @ run.forcing.place.rows("cup")[0]
    air = trial.drive.inputs["ambient"][1:, 0]
    near = trial.rig.screw.overlap(0.0, 50.0) / 5
    whole = (0.2 * (air[:, None] - cells) / trial.rig.screw.cells + 0.1 * near * (cup[:, None] - cells)).sum(axis=1)
    np.testing.assert_allclose(found @ np.array([zone.length_m for zone in places]), whole, atol=1e-9)
    assert whole.min() < -0.01
