"""What is asked of an own effect before it is used: structure and numbers that depend on nothing that they may not."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.battery.admitted import admit
from estimator.effect import Effect, Param
from estimator.errors import EffectError
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.terms import SCREW, Heat
from tests.conftest import EXAMPLES


class Jet(Effect):
    """A jet cools the screw all along.

    q = -P
    """

    power = Param(5.0, "W", lo=0.0, hi=50.0, null=0.0, source="a guess")
    drawn = np.random.default_rng(1)

    def terms(self, p, u, rig):
        yield Heat(SCREW, -p.power * u.motion.freshness(100.0, 100.0) / rig.screw.cells)


def used(full, terms):
    """The model with the jet, whose terms are these."""
    own = type("Jet", (Jet,), {"__doc__": Jet.__doc__, "terms": terms} if terms else {"__doc__": Jet.__doc__})
    return replace(full + own, use={"jet": "own.py:Jet"}, name="m.toml")


def test_an_effect_that_remembers_motion_is_admitted(full, rig):
    admit(used(full, None), rig)


@pytest.mark.parametrize("name", ["heated_rod", "two_heaters"])
def test_the_effects_of_the_examples_are_admitted(name):
    admit(load_model(EXAMPLES / name / "model.toml"), load_rig(EXAMPLES / name))


def switched_by_value(self, p, u, rig):
    if p.power > 5.0:
        yield Heat("nut", p.power)
    yield Heat(SCREW, -p.power / rig.screw.cells)


def switched_by_motion(self, p, u, rig):
    yield Heat(SCREW if u.omega.max() > 0 else "nut", 0.1)


def of_all_ticks(self, p, u, rig):
    yield Heat(SCREW, -p.power * u["ambient"].max() / 1e4)


def by_chance(self, p, u, rig):
    yield Heat(SCREW, -p.power * self.drawn.random())


def of_one_axis(self, p, u, rig):
    yield Heat(SCREW, -p.power * u.omega[:, 0])


@pytest.mark.parametrize(
    ("terms", "message"),
    [
        (switched_by_value, "yields other terms with power = 50; structure never depends on values"),
        (switched_by_motion, "yields other terms while driving than at rest; structure never"),
        (of_all_ticks, "term 1, Heat of screw: q of a tick changes with the ticks that are asked for beside it"),
        (by_chance, "term 1, Heat of screw: q of a tick changes with the ticks that are asked for beside it"),
        (of_one_axis, "term 1, Heat of screw: q has the shape (12,), must be a number or fit (12, 270)"),
    ],
)
def test_what_depends_on_what_it_may_not_is_named(full, rig, terms, message):
    with pytest.raises(EffectError) as caught:
        admit(used(full, terms), rig)
    assert str(caught.value).startswith(f"m.toml: jet (own.py:Jet): {message}")
