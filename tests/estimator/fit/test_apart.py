"""Parameters that some recordings cannot tell from others are found, and left where they were."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.effect import Effect, Param
from estimator.effects.nut import per_cell
from estimator.errors import InputError
from estimator.fit.fit import fit
from estimator.fit.untold import untold
from estimator.terms import Heat
from estimator.work import Runs

TRUE = {"nut_friction.power": 66.0, "nut_friction.n": 1.2}
TOLD = ("nut_friction.power", "nut_friction.power_nut", "nut_friction.n")
DICE = np.random.default_rng(3)


def columns(*each) -> np.ndarray:
    return np.stack(each, axis=-1)


def test_of_two_that_are_alike_the_first_is_kept():
    power, lag = DICE.standard_normal((2, 200))
    assert untold(columns(power, lag, -3 * power), ["power", "lag", "exponent"]) == {"exponent": "power"}
    assert untold(columns(-3 * power, lag, power), ["exponent", "lag", "power"]) == {"power": "exponent"}


def test_a_sum_of_others_is_like_the_one_it_holds_most_of():
    a, b, c = DICE.standard_normal((3, 200))
    assert untold(columns(a, b, c, 4 * a + b), ["a", "b", "c", "d"]) == {"d": "a"}


def test_one_without_influence_is_like_none():
    a, none = DICE.standard_normal(50), np.zeros(50)
    assert untold(columns(none, a), ["idle", "a"]) == {"idle": ""}
    assert untold(columns(none, none), ["idle", "too"]) == {"idle": "", "too": ""}


@pytest.mark.parametrize(("apart", "found"), [(0.1, {}), (0.005, {"b": "a"})])
def test_a_little_of_its_own_is_enough(apart, found):
    a, own = DICE.standard_normal((2, 5000))
    assert untold(columns(a, a + apart * own), ["a", "b"]) == found


def free(model, *paths: str):
    """The model with these parameters free, and no others."""
    return model.with_values({path: replace(value, fixed=path not in paths) for path, value in model.values.items()})


@pytest.fixture(scope="module")
def full(full):
    """Without what takes its share of the nut's power, and none of another heat's."""
    return full - "warm_grease"


@pytest.fixture(scope="module")
def slow(rig, full, driven, live):
    """Driven at one speed, half of the reference."""
    return live(full.with_values(TRUE), rig, driven(rig, 400, (20, 240), 87.3), seed=5).recording


def test_at_one_speed_the_table_decides_between_power_and_exponent(slow, rig, full):
    """What goes in at that speed is found, and neither is left out."""
    power, _, n = fit(free(full, *TOLD), Runs(rig, [slow])).parameters
    assert not n.like
    assert n.value == pytest.approx(full.param(n.path).value, abs=0.1 * full.param(n.path).sd + n.sd)
    assert not n.determined
    assert power.value * 0.5**n.value == pytest.approx(66.0 * 0.5**1.2, rel=0.01)
    assert abs(power.value - 66.0) < 3 * power.sd


def test_at_two_speeds_both_are_found(slow, rig, full, driven, live):
    fast = live(full.with_values(TRUE), rig, driven(rig, 400, (20, 240), 174.5), seed=6).recording
    power, _, n = fit(free(full, *TOLD), Runs(rig, [slow, fast])).parameters
    assert power.value == pytest.approx(66.0, rel=0.02)
    assert n.value == pytest.approx(1.2, abs=2 * n.sd)
    assert n.sd < 0.04
    assert n.determined


class Doubled(Effect):
    """The nut's heat once more, of which no table says anything."""

    scales = ("nut_friction",)
    share = Param(0.0, "1", lo=-1.0, hi=1.0, null=0.0)
    again = Param(0.0, "1", lo=-1.0, hi=1.0, null=0.0)

    def terms(self, p, u, rig):
        heat = p.nut_friction.power * u.speed_law(rig.screw, p.nut_friction.n) * per_cell(rig)
        yield Heat("screw", (p.share + p.again) * heat, over=u.coverage)


def test_one_without_a_table_value_is_left_only_beside_another_without(slow, rig, full):
    """Between one that has a table value and one that has none, the table decides."""
    runs, model = Runs(rig, [slow]), full + Doubled
    share, again = fit(free(model, "doubled.share", "doubled.again"), runs).parameters
    assert (again.like, again.value) == ("doubled.share", 0.0)
    assert not share.like
    power, share = fit(free(model, "nut_friction.power", "doubled.share"), runs).parameters
    assert power.like == share.like == ""
    assert power.value == pytest.approx(60.0, abs=0.2)
    assert power.sd == pytest.approx(20.0, rel=0.05)
    assert share.sd > 0.2


def test_recordings_that_say_nothing_of_a_parameter_are_refused(small, small_model, driven, live):
    """At rest no friction shows; a noise level beside it is fitted all the same."""
    rig, full = small, small_model
    still = live(full, rig, driven(rig, 120, (120, 120)), seed=7).recording
    with pytest.raises(InputError, match=r"say nothing of nut_friction\.power, nut_friction\.n: free others"):
        fit(free(full, "nut_friction.power", "nut_friction.n"), Runs(rig, [still]))
    power, sd = fit(free(full, "nut_friction.power", "thermometers.sd"), Runs(rig, [still])).parameters
    assert power.value == full["nut_friction.power"]
    assert np.isfinite(sd.sd)
