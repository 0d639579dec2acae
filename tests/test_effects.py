"""One battery for every effect of the catalogue."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, replace

import numpy as np
import pytest

from estimator import assemble
from estimator.effect import Effect, Param
from estimator.effects import CATALOGUE
from estimator.errors import SetupError
from estimator.forcing import Forcing
from estimator.inputs import Inputs
from estimator.model import Model, model_of
from estimator.openloop import OpenLoop
from estimator.record import Array
from estimator.start import Start
from estimator.terms import Expand, Heat, Lag, Read, Spot, Store
from estimator.view import View

EFFECTS = list(CATALOGUE.values())
PARAMETERS = [f"{effect.name}.{key}" for effect in EFFECTS for key in effect.params]
WITHOUT_NULL = {"conduction", "displacement"}  # without them there is no bar, or no channel
NULL = [effect for effect in EFFECTS if effect.name not in WITHOUT_NULL | {"thermometers"}]


def open_loop(model: Model, rig, drive) -> Array:
    """What the channels read by the model alone, (K, m)."""
    forcing = Forcing(model, rig, Start(22.0, 0.0, dict.fromkeys(rig.inputs, 0.0)))
    ticks = forcing.ticks(forcing.read(drive))
    run, out = OpenLoop(np.full(forcing.place.size, 22.0), forcing.readings, rig.tick_s), []
    for regime, heat in zip(ticks.regime, ticks.heat, strict=True):
        run.step(forcing.transition(regime), heat)
        out.append(run.reading)
    return np.array(out) + ticks.offset


@pytest.fixture(scope="module")
def drive(rig, driven):
    """A drive and some rest in which every input changes."""
    drive = driven(rig, 120, (5, 80))
    changes = {name: 22 + i / 60 * np.arange(120) for i, name in enumerate(rig.inputs, start=1)}
    return replace(drive, inputs={**changes, "position": drive.inputs["position"]})


@pytest.fixture(scope="module")
def u(rig) -> Inputs:
    """Three regimes: parked, and two speeds at different places."""
    coverage = rig.screw.overlap(np.array([186.0, 300.0, 400.0]), np.array([361.0, 475.0, 575.0]))
    rise = {name: np.array([[0.5], [1.0], [2.0]]) for name in rig.inputs}
    return Inputs(np.array([[0.0], [60.0], [174.5]]), coverage, rise, rise)


def test_the_catalogue_is_keyed_by_name():
    assert [effect.name for effect in EFFECTS] == list(CATALOGUE)
    assert {"conduction", "nut_friction", "anchor_housing", "thermometers", "displacement"} <= set(CATALOGUE)


@pytest.mark.parametrize("effect", NULL, ids=lambda e: e.name)
def test_invisible_at_null(effect, full, rig, drive):
    nulls = {f"{effect.name}.{key}": param.null for key, param in effect.params.items() if param.null is not None}
    assert nulls
    without = open_loop(full - effect.name, rig, drive)
    np.testing.assert_allclose(open_loop(full.with_values(nulls), rig, drive), without, rtol=0, atol=1e-9)
    for path, null in nulls.items():
        param = full.param(path)
        seen = full.with_values({**nulls, path: param.hi if param.value == null else param.value})
        assert abs(open_loop(seen, rig, drive) - without).max() > 0.001, path


class Ideal(Effect):
    """Thermometers without a fault: y = T(x)."""

    def terms(self, p, u, rig):
        for name in rig.thermometers:
            yield Read(name, {"screw": Spot(rig.channels[name].at_mm)}, 0.03)


def test_thermometers_at_null_read_their_spot(full, rig, drive):
    nulls = {"thermometers.tau": 0.0, "thermometers.board": 0.0}
    ideal = open_loop((full - "thermometers") + Ideal, rig, drive)[:, :15]
    np.testing.assert_allclose(open_loop(full.with_values(nulls), rig, drive)[:, :15], ideal, rtol=0, atol=1e-9)
    for path, other in (("thermometers.tau", 8.0), ("thermometers.board", 0.01)):
        seen = open_loop(full.with_values({**nulls, path: other}), rig, drive)[:, :15]
        assert abs(seen - ideal).max() > 0.01


def structure(effect: type[Effect], values: dict, u: Inputs, rig) -> list:
    """What an effect yields, without numbers."""
    found = []
    for term in effect().terms(effect().namespace(values), u, rig):
        names = [(f.name, getattr(term, f.name)) for f in fields(term) if isinstance(getattr(term, f.name), str)]
        weights = tuple(getattr(term, "weights", ()))
        shapes = [np.shape(getattr(term, f.name)) for f in fields(term) if f.name in ("capacity", "g", "q", "tau")]
        found.append((type(term), names, weights, shapes))
    return found


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_structure_is_independent_of_values(effect, u, rig):
    usual = structure(effect, {}, u, rig)
    assert usual
    for choose in (lambda p: p.lo, lambda p: p.hi, lambda p: p.null if p.null is not None else p.value):
        assert structure(effect, {key: choose(param) for key, param in effect.params.items()}, u, rig) == usual


def numbers(term) -> Iterator[tuple[str, Array]]:
    """Every number of a term by name."""
    for f in fields(term):
        value = getattr(term, f.name)
        if f.name == "weights":
            yield from ((node, np.asarray(getattr(weight, "weight", weight))) for node, weight in value.items())
        elif not isinstance(value, (str, bool, type(None))):
            yield f.name, np.asarray(value)


def of_terms(model: Model, effect: str, u: Inputs, rig) -> dict:
    own = Model({effect: model.effects[effect]}, {k: v for k, v in model.values.items() if k.startswith(f"{effect}.")})
    return {(i, name): value for i, t in enumerate(own.terms(u, rig)) for name, value in numbers(t)}


def of_network(model: Model, u: Inputs, rig, place) -> dict:
    network = assemble.network(model, rig, place, u)
    terms = list(model.terms(u, rig))
    readings = {name: value for name, value in vars(assemble.readings(terms, rig, place)).items() if name != "spans"}
    given = {"heat": assemble.heat(terms, place, len(u)), "offset": assemble.offsets(terms, rig, len(u))}
    return {**vars(network), **readings, **given}


@pytest.mark.parametrize("path", PARAMETERS)
def test_derivative_by_complex_step_equals_central_differences(path, full, u, rig):
    """Of all that the effect yields, and of the assembled network, readings, heat and offsets."""
    effect = path.partition(".")[0]
    place = assemble.layout(list(full.terms(u, rig)), rig)
    value = full[path] or 0.01
    step = 1e-4 * abs(value)

    def at(number):
        model = full.with_values({path: number})
        return {**of_terms(model, effect, u, rig), **of_network(model, u, rig, place)}

    slope, up, down = at(value + 1e-30j), at(value + step), at(value - step)
    moved = []
    for name, number in slope.items():
        assert np.isfinite(number).all()
        difference = (up[name] - down[name]) / (2 * step)
        rounding = 1e-13 * abs(up[name]).max() / step
        atol = 1e-5 * abs(difference).max() + rounding
        np.testing.assert_allclose(number.imag / 1e-30, difference, rtol=0, atol=atol, err_msg=str(name))
        moved.append(abs(difference).max() > 0)
    assert any(moved)


@pytest.mark.parametrize("turn", [0, 3, 7])
def test_order_of_effects_does_not_matter(turn, full, rig, drive):
    other = model_of([*EFFECTS[turn:], *EFFECTS[:turn]][::-1]).with_values({"nut_friction.power": 80.0})
    same = full.with_values({"nut_friction.power": 80.0})
    np.testing.assert_allclose(open_loop(other, rig, drive), open_loop(same, rig, drive), rtol=0, atol=1e-9)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_links_conserve_heat(effect, full, u, rig):
    """What an effect takes out of the nodes goes to measured inputs, and nowhere else."""
    place = assemble.layout(list(full.terms(u, rig)), rig, reduced=False)
    network, without = assemble.network(full, rig, place, u), assemble.network(full - effect.name, rig, place, u)
    own = network.conductance - without.conductance
    outside = (network.inflow - without.inflow).sum(axis=2)
    np.testing.assert_allclose(own.sum(axis=1), outside, atol=1e-9)
    np.testing.assert_allclose(own.sum(axis=2), outside, atol=1e-9)
    assert (outside >= -1e-9).all()


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_documented(effect):
    assert effect.sentence().endswith(".")
    assert "=" in effect.equation()
    assert len(effect.sentence()) < 130
    for key, param in effect.params.items():
        assert param.unit, key
        assert param.source, key
        assert np.isfinite([param.lo, param.hi]).all(), key


@pytest.mark.parametrize("path", PARAMETERS)
def test_default_and_null_are_inside_the_bounds(path, full):
    param = full.param(path)
    assert param.lo < param.hi
    assert param.lo <= param.value <= param.hi
    assert param.null is None or param.lo <= param.null <= param.hi


def terms_of(full, effect: str, rig, u):
    own = CATALOGUE[effect]
    return list(own().terms(own().namespace({}), u, rig))


@pytest.mark.parametrize("effect", ["nut_friction", "anchor_friction", "free_friction"])
def test_friction_gives_its_power_at_the_reference_speed(effect, full, rig, u):
    terms = terms_of(full, effect, rig, replace(u, omega=np.full((3, 1), 1667 * 2 * np.pi / 60)))
    (heat,) = (term for term in terms if term.node == "screw")
    assert isinstance(heat, Heat)
    np.testing.assert_allclose(np.sum(heat.q * heat.over, axis=1), full[f"{effect}.power"], rtol=1e-9)


def test_heat_stops_with_the_screw(full, rig, u):
    for name in CATALOGUE:
        for term in terms_of(full, name, rig, u):
            if isinstance(term, Heat):
                assert (np.broadcast_to(term.q, (3, np.shape(term.q)[-1]))[0] == 0).all()


def test_the_air_cools_the_whole_surface(full, rig, u):
    (still,) = terms_of(full, "still_air", rig, u)
    assert (still.a, still.b) == ("screw", "ambient")
    assert still.g * rig.screw.cells == pytest.approx(full["still_air.h"] * np.pi * 0.04 * 1.08)
    (rotating,) = terms_of(full, "rotating_convection", rig, u)
    assert rotating.g[0, 0] == 0
    assert rotating.g[1, 0] / rotating.g[2, 0] == pytest.approx((60 / 174.5) ** full["rotating_convection.m"])


def test_only_conduction_and_bodies_store_heat(full, rig, u):
    stored = {t.node: name for name in CATALOGUE for t in terms_of(full, name, rig, u) if isinstance(t, Store)}
    assert stored == {
        "screw": "conduction", "nut": "nut_body", "anchor_housing": "anchor_housing", "free_housing": "free_housing",
    }  # fmt: skip


def test_every_thermometer_is_read_once_and_lags(full, rig, u):
    terms = terms_of(full, "thermometers", rig, u)
    for kind in (Read, Lag):
        assert [t.channel for t in terms if isinstance(t, kind)] == list(rig.thermometers)


def test_a_warm_probe_adds_and_a_warm_bar_takes_away(full, rig, u):
    (reading,) = terms_of(full, "displacement", rig, u)
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
    fast = replace(u, omega=np.full((3, 1), 1667 * 2 * np.pi / 60))

    def heat(model: Model) -> tuple[Array, assemble.Layout]:
        terms = list(model.terms(fast, rig))
        place = assemble.layout(terms, rig)
        return assemble.heat(terms, place, 3), place

    other = {f"{friction}.{key}": 20.0}
    node = {"nut_body": "nut"}.get(body, body)
    (cold, place), (warm, _) = heat(full.with_values({f"{friction}.{key}": 0.0})), heat(full.with_values(other))
    added = np.zeros(place.size)
    added[place.state(node)] = 20.0
    np.testing.assert_allclose(warm - cold, np.tile(added, (3, 1)), atol=1e-9)
    bare = full - body
    np.testing.assert_array_equal(heat(bare.with_values(other))[0], heat(bare)[0])
    assert node not in heat(bare)[1].nodes


def test_a_contact_s_two_sides_have_one_exponent(full, rig, u):
    for name, n in (("nut_friction", 1.2), ("anchor_friction", 1.5), ("free_friction", 0.9)):
        own = CATALOGUE[name]
        for heat in own().terms(own().namespace({"n": n}), u, rig):
            total = np.sum(np.atleast_2d(heat.q * heat.over), axis=1)
            assert total[1] / total[2] == pytest.approx((60 / 174.5) ** n)


def test_an_effect_built_on_another_keeps_its_parameters(full, rig, u):
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


def test_default_outside_its_bounds_is_refused():
    with pytest.raises(SetupError, match=r"^parameter default 5.0 W is outside 0.0 ... 3.0$"):
        Param(5.0, "W", lo=0.0, hi=3.0)


def test_an_effect_without_an_equation_is_refused():
    with pytest.raises(SetupError, match=r"^effect Silent: the docstring with its equation is missing$"):
        type("Silent", (Effect,), {})
