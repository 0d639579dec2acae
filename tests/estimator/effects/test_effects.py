"""Every effect of the catalogue: the battery, and what each of the shipped model's says about heat and readings."""

import re
from dataclasses import replace

import numpy as np
import pytest

from estimator.battery.battery import CHECKS, battery
from estimator.battery.exercise import instants, open_loop, run as exercise
from estimator.effect import Effect, Param
from estimator.effects import CATALOGUE, HEAT, MOUNTING, READING, STRUCTURE
from estimator.errors import SetupError
from estimator.inputs.inputs import Inputs
from estimator.inputs.start import Start
from estimator.model import Model, model_of
from estimator.network import assemble
from estimator.network.forcing import Forcing
from estimator.network.layout import Layout, layout
from estimator.record import Array
from estimator.state.view import View
from estimator.terms import Expand, Heat, Lag, Read, Spot, Store
from tests.conftest import terms_of

EFFECTS = list(CATALOGUE.values())
WITHOUT_NULL = {  # never searched for
    "conduction", "displacement", "held_ends", "nut_balls", "nut_flange", "housing_shells", "free_convection",
    "warm_grease",
}  # fmt: skip
ALWAYS = {"local_heat", "free_convection"}  # heats at rest, too


@pytest.fixture(scope="module")
def drive(rig):
    """Drives and stops in which every input changes."""
    return exercise(rig)


@pytest.fixture(scope="module")
def u(rig) -> Inputs:
    """Three regimes: parked, and two even speeds at different places."""
    return replace(instants(rig), unevenness=1.0)


def test_the_catalogue_is_keyed_by_name_and_sorted_by_kind():
    assert [effect.name for effect in EFFECTS] == list(CATALOGUE)
    assert [*STRUCTURE, *MOUNTING, *HEAT, *READING] == EFFECTS
    assert {"conduction", "nut_friction", "anchor_housing", "thermometers", "displacement"} <= set(CATALOGUE)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_the_battery(effect, full, rig):
    findings = battery(effect, full, rig)
    assert [finding.check for finding in findings] == [*CHECKS]
    assert [(finding.check, finding.detail) for finding in findings if not finding.ok or finding.detail] == []


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_what_it_leaves_in_the_readings_is_said(effect):
    assert effect.trace.endswith(".")
    assert any(param.null is not None for param in effect.params.values()) != (effect.name in WITHOUT_NULL)


class Ideal(Effect):
    """Thermometers without a fault: y = T(x)."""

    def terms(self, p, u, rig):
        for name in rig.thermometers:
            yield Read(name, {"screw": Spot(rig.channels[name].at_mm)}, 0.03)


def test_thermometers_at_null_read_their_spot(full, rig, drive):
    nulls = {"thermometers.tau": 0.0, "thermometers.board": 0.0, "thermometers.bore": 0.0}
    ideal = open_loop((full - "thermometers") + Ideal, rig, drive)[:, :15]
    np.testing.assert_allclose(open_loop(full.with_values(nulls), rig, drive)[:, :15], ideal, rtol=0, atol=1e-9)
    for path, other in (("thermometers.tau", 8.0), ("thermometers.board", 0.01), ("thermometers.bore", 1.0)):
        seen = open_loop(full.with_values({**nulls, path: other}), rig, drive)[:, :15]
        assert abs(seen - ideal).max() > 0.01


@pytest.mark.parametrize("turn", [0, 3, 7, 20])
def test_order_of_effects_does_not_matter(turn, every, rig, drive):
    other = model_of([*EFFECTS[turn:], *EFFECTS[:turn]][::-1]).with_values({"nut_friction.power": 80.0})
    same = every.with_values({"nut_friction.power": 80.0})
    np.testing.assert_allclose(open_loop(other, rig, drive), open_loop(same, rig, drive), rtol=0, atol=1e-9)


@pytest.mark.parametrize("effect", ["nut_friction", "anchor_friction", "free_friction"])
def test_friction_gives_its_power_at_the_reference_speed(effect, full, rig, u):
    terms = terms_of(effect, rig, replace(u, omega=np.full((3, 1), 1667 * 2 * np.pi / 60)))
    (heat,) = (term for term in terms if term.node == "screw")
    assert isinstance(heat, Heat)
    np.testing.assert_allclose(np.sum(heat.q * heat.over, axis=1), full[f"{effect}.power"], rtol=1e-9)


def test_heat_stops_with_the_screw(rig, u):
    for name in set(CATALOGUE) - ALWAYS:
        for term in terms_of(name, rig, u):
            if isinstance(term, Heat):
                assert (np.broadcast_to(term.q, (3, np.shape(term.q)[-1]))[0] == 0).all()


def test_the_air_cools_the_whole_surface(full, rig, u):
    (still,) = terms_of("still_air", rig, u)
    assert (still.a, still.b) == ("screw", "ambient")
    assert still.g * rig.screw.cells == pytest.approx(full["still_air.h"] * np.pi * 0.04 * 1.08)
    (rotating,) = terms_of("rotating_convection", rig, u)
    assert rotating.g[0, 0] == 0
    assert rotating.g[1, 0] / rotating.g[2, 0] == pytest.approx((1 / 3) ** full["rotating_convection.m"])


def test_only_conduction_and_bodies_store_heat(rig, u):
    stored = {t.node: name for name in CATALOGUE for t in terms_of(name, rig, u) if isinstance(t, Store)}
    assert stored == {
        "screw": "conduction", "nut": "nut_body", "nut_flange": "nut_flange", "anchor_housing": "anchor_housing",
        "free_housing": "free_housing", "anchor_shell": "housing_shells", "free_shell": "housing_shells",
    }  # fmt: skip


def test_every_thermometer_is_read_once_and_lags(rig, u):
    terms = terms_of("thermometers", rig, u)
    for kind in (Read, Lag):
        assert [t.channel for t in terms if isinstance(t, kind)] == list(rig.thermometers)


def test_a_warm_probe_adds_and_a_warm_bar_takes_away(full, rig, u):
    (reading,) = terms_of("displacement", rig, u)
    added = full["displacement.probe"] - full["displacement.bar"]
    np.testing.assert_allclose(reading.offset[:, 0], added * np.array([0.5, 1, 2]))


def lengths(model: Model, rig) -> dict[str, Array]:
    """Weights of all that is a growth of the screw, and the rows of the thermometers."""
    forcing = Forcing(model, rig, Start(22.0, 0.0, dict.fromkeys(rig.inputs, 0.0)))
    view = View(rig, forcing.place, forcing.terms)
    return {
        "elongation": view.growth,
        "displacement": forcing.readings.rows[15],
        "table": view.table_error(150.0),
        "thermometers": forcing.readings.rows[:15],
    }


class Longer(Effect):
    """A second error of the coefficient: rho = rho_rig (1 + 0.02)."""

    def terms(self, p, u, rig):
        yield Expand(0.02)


def test_another_coefficient_makes_every_length_longer_alike(full, rig):
    usual = lengths(full - "expansion_error", rig)
    assert abs(usual["elongation"]).max() > 0.1
    np.testing.assert_array_equal(usual["displacement"], usual["elongation"])
    for model, share in (
        (full.with_values({"expansion_error.error": 0.05}), 1.05),
        (full.with_values({"expansion_error.error": -0.05}), 0.95),
        (full.with_values({"expansion_error.error": 0.05}) + Longer, 1.07),
    ):
        found = lengths(model, rig)
        for name in ("elongation", "displacement", "table"):
            np.testing.assert_allclose(found[name], share * usual[name], rtol=1e-12, atol=0, err_msg=name)
        np.testing.assert_array_equal(found["thermometers"], usual["thermometers"])


@pytest.mark.parametrize(
    ("friction", "key", "body"),
    [
        ("nut_friction", "power_nut", "nut_body"),
        ("anchor_friction", "power_housing", "anchor_housing"),
        ("free_friction", "power_housing", "free_housing"),
    ],
)
def test_friction_heats_the_body_beside_the_screw_where_there_is_one(friction, key, body, full, rig, u):
    """All of it arrives in the body with the body; without it the heat is gone, and nothing else has changed."""
    full -= "warm_grease"  # takes its share of these heats
    fast = replace(u, omega=np.full((3, 1), 1667 * 2 * np.pi / 60))

    def heat(model: Model) -> tuple[Array, Layout]:
        terms = list(model.terms(fast, rig))
        place = layout(terms, rig)
        return assemble.heat(terms, place, 3), place

    other = {f"{friction}.{key}": 20.0}
    node = {"nut_body": "nut"}.get(body, body)
    (cold, place), (warm, _) = heat(full.with_values({f"{friction}.{key}": 0.0})), heat(full.with_values(other))
    added = np.zeros(place.size)
    added[place.state(node)] = 20.0
    np.testing.assert_allclose(warm - cold, np.tile(added, (3, 1)), atol=1e-9)
    bare = full - "nut_flange" - "housing_shells" - body
    np.testing.assert_array_equal(heat(bare.with_values(other))[0], heat(bare)[0])
    assert node not in heat(bare)[1].nodes


def test_a_nut_without_a_joint_is_one_body(full, rig, drive):
    """And with one, what the balls run in brings more heat back after a stop."""
    one = open_loop(full - "nut_flange", rig, drive)
    tight, loose = (open_loop(full.with_values({"nut_flange.r": r}), rig, drive) for r in (0.003, 0.2))
    assert abs(tight - one).max() < 0.05 < 0.2 < abs(loose - one).max()


def test_a_housing_without_a_joint_is_one_body(full, rig, drive):
    """And with one, the rings bring more heat back after a stop."""
    one = open_loop(full - "housing_shells", rig, drive)
    tight, loose = (open_loop(full.with_values({"housing_shells.r": r}), rig, drive) for r in (0.003, 0.2))
    assert abs(tight - one).max() < 0.05 < 0.1 < abs(loose - one).max()


def test_shells_are_of_the_housings_that_the_model_has(full, rig, u):
    def stored(model: Model) -> list[str]:
        return [term.node for term in model.terms_of("housing_shells", u, rig) if isinstance(term, Store)]

    assert stored(full) == ["anchor_shell", "free_shell"]
    assert stored(full - "free_housing") == ["anchor_shell"]
    with pytest.raises(SetupError, match=r"housing_shells: needs the effect 'anchor_housing'"):
        stored(full - "free_housing" - "anchor_housing")


@pytest.mark.parametrize(
    ("input_", "outer", "joint", "whole"),
    [
        ("nut", "nut_flange", "nut_flange", "nut"),
        ("anchor_bracket", "anchor_shell", "housing_shells", "anchor_housing"),
    ],
)
def test_a_body_s_thermometer_shows_its_outer_part_where_it_has_one(input_, outer, joint, whole, full, rig, u):
    for model, shown in ((full, [outer]), (full - joint, [whole])):
        stores = [term for term in model.terms(u, rig) if isinstance(term, Store) and term.start == input_]
        assert [term.node for term in stores if term.shown] == shown


def test_a_contact_s_two_sides_have_one_exponent(rig, u):
    for name, n in (("nut_friction", 1.2), ("anchor_friction", 1.5), ("free_friction", 0.9)):
        own = CATALOGUE[name]
        for heat in own().terms(own().namespace({"n": n}), u, rig):
            total = np.sum(np.atleast_2d(heat.q * heat.over), axis=1)
            assert total[1] / total[2] == pytest.approx((1 / 3) ** n)


def test_an_effect_built_on_another_keeps_its_parameters(rig, u):
    class Mine(CATALOGUE["nut_friction"]):
        """As nut_friction, with a share of ours: q = share P."""

        power = Param(70.0, "W", lo=0.0, hi=90.0, source="ours")
        share = Param(0.5, "1", lo=0.0, hi=1.0, source="ours")

    theirs = CATALOGUE["nut_friction"]
    assert list(Mine.params) == [*theirs.params, "share"]
    assert (Mine.params["power"].value, theirs.params["power"].value) == (70.0, 60.0)
    assert Mine.params["n"] is theirs.params["n"]
    assert "share" not in theirs.params
    (heat, _) = Mine().terms(Mine().namespace({}), replace(u, omega=np.full((3, 1), 1667 * 2 * np.pi / 60)), rig)
    np.testing.assert_allclose(np.sum(heat.q * heat.over, axis=1), 70.0)


@pytest.mark.parametrize(
    ("param", "message"),
    [
        (Param(5.0, "W", lo=0.0, hi=3.0), "value = 5 W is outside 0 ... 3"),
        (Param(5.0, "W", lo=0.0, hi=9.0, null=-1.0), "null = -1 W is outside 0 ... 9"),
        (Param(5.0, "W", lo=9.0, hi=0.0), "lo = 9 is not below hi = 0"),
        (Param(5.0, "W", lo=5.0, hi=5.0), "lo = 5 is not below hi = 5"),
        (Param(5.0, "W", lo=np.nan, hi=9.0), "lo = nan is not below hi = 9"),
        (Param(np.inf, "W"), "value is inf, must be a number up to 1e+12"),
        (Param(np.nan, "W"), "value is nan, must be a number up to 1e+12"),
        (Param(5.0, "W", null=np.nan), "null is nan, must be a number up to 1e+12"),
        (Param("5", "W"), "value is '5', must be a number"),
        (Param(5.0, "W", lo="0"), "lo is '0', must be a number"),
        (Param(True, "W"), "value is True, must be a number"),
        (Param(np.ones(2), "W"), "value is array([1., 1.]), must be a number"),
        (Param(5.0, "W", sd=0.0), "sd is 0, must be above 0"),
        (Param(5.0, "W", sd=-1.0), "sd is -1, must be above 0"),
        (Param(5.0, 3), "unit and source must be texts"),
        (Param(5.0, "W", over="moon"), 'over must be "", "place" or "channel", and fixed True or False'),
    ],
)
def test_a_parameter_that_cannot_be_is_named(param, message):
    with pytest.raises(SetupError, match=f"^effect Odd: power: {re.escape(message)}$"):
        type("Odd", (Effect,), {"__doc__": "Odd: q = P.", "power": param})


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ({"terms": 5}, "it needs a method terms(self, p, u, rig), and has no __init__: values come with p"),
        ({"__init__": lambda self, x: None}, "it needs a method terms(self, p, u, rig), and has no __init__"),
        ({"scales": "nut_friction"}, "scales is 'nut_friction', must be the names of other effects"),
        ({"scales": None}, "scales is None, must be the names of other effects"),
        ({"trace": None}, "trace is None, must be a text"),
        ({"use": Param(5.0, "W")}, "use: a model file means the effect's file by it"),
    ],
)
def test_a_class_that_is_no_effect_is_named(attributes, message):
    with pytest.raises(SetupError, match=f"^effect Odd: {re.escape(message)}"):
        type("Odd", (Effect,), {"__doc__": "Odd: q = P.", **attributes})


def test_an_effect_without_an_equation_is_refused():
    with pytest.raises(SetupError, match=r"^effect Silent: the docstring with its equation is missing$"):
        type("Silent", (Effect,), {})
