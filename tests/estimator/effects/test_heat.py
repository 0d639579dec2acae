"""What the effects that heat or cool beside the shipped model's say: friction's habits, places, surroundings."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.battery.battery import battery
from estimator.battery.bench import without
from estimator.battery.exercise import instants, open_loop
from estimator.effects import CATALOGUE
from estimator.errors import SetupError
from estimator.inputs.inputs import Inputs, no_inputs
from estimator.inputs.motion import MotionReader
from estimator.network import assemble
from estimator.network.layout import layout
from estimator.terms import START, Heat, Link, Shift
from tests.conftest import FAST, terms_of

REFERENCE = 1667 * 2 * np.pi / 60
STEFAN_BOLTZMANN = 5.670374e-8


@pytest.fixture(scope="module")
def u(rig) -> Inputs:
    """Parked, and two even speeds at different places."""
    return replace(instants(rig), unevenness=1.0)


def moving(rig, omega) -> Inputs:
    """Inputs of a run from its first tick on, of speeds (ticks,); the nut in the middle."""
    omega = np.asarray(omega, dtype=float)
    coverage = np.tile(rig.screw.overlap(400.0, 575.0), (len(omega), 1))
    return replace(no_inputs(rig, omega[:, None], coverage), motion=MotionReader(1.0).read(omega))


def watts(terms, node: str, ticks: int) -> np.ndarray:
    """Heat that terms put into a node, (ticks,)."""
    total = np.zeros(ticks)
    for term in terms:
        if isinstance(term, Heat) and term.node == node:
            total += np.atleast_2d(term.q * term.over).sum(axis=1)
    return total


# --- friction


SPEEDS = [("nut_speed_exponent", ["nut"]), ("bearing_speed_exponent", ["anchor", "free"])]


@pytest.mark.parametrize(("effect", "places"), SPEEDS)
def test_another_exponent_is_nothing_at_the_reference_speed(effect, places, rig, u):
    at_reference = replace(u, omega=np.full((3, 1), REFERENCE))
    for term in terms_of(effect, rig, at_reference, extra=0.4):
        assert abs(np.asarray(term.q)).max() < 1e-9


@pytest.mark.parametrize(("effect", "places"), SPEEDS)
def test_friction_and_its_other_exponent_are_friction_of_that_exponent(effect, places, rig, u):
    """P w^n + P w^n (w^extra - 1) = P w^(n + extra), in the screw and in the bodies."""
    inside = replace(u, coverage=np.tile(rig.screw.overlap(400.0, 575.0), (3, 1)))
    for place in places:
        n = CATALOGUE[f"{place}_friction"].params["n"].value
        node = "nut" if place == "nut" else f"{place}_housing"
        under = [t for t in terms_of(effect, rig, inside, extra=0.3) if _at(t, node, place, rig)]
        plain, other = (terms_of(f"{place}_friction", rig, inside, n=exponent) for exponent in (n, n + 0.3))
        for where in ("screw", node):
            sum_of_both = watts(plain, where, 3) + watts(under, where, 3)
            np.testing.assert_allclose(sum_of_both, watts(other, where, 3), rtol=1e-12, atol=1e-12)
        assert watts(under, "screw", 3)[1] < -0.9


def _at(term: Heat, node: str, place: str, rig) -> bool:
    """Whether a heat is in the body, or in the screw where that body's bearing is."""
    if term.node == node or place == "nut":
        return term.node in (node, "screw")
    return term.node == "screw" and term.over[np.argmin(abs(rig.screw.x_mm - rig.supports[place].at_mm))] > 0


def test_thinning_takes_heat_in_proportion_to_the_warmth(rig, u):
    """Under the nut P w^n times the slope of e^(-rate (T - T_ref)) at T_ref + 10 K; at a bearing by ratio times it."""
    terms = terms_of("friction_thinning", rig, u, rate=0.02, ratio=1.5)
    links = [term for term in terms if isinstance(term, Link)]
    bodies = ("nut", "anchor_housing", "free_housing")
    ends = {*((node, START) for node in ("screw", *bodies)), *(("screw", body) for body in bodies)}
    assert {(link.a, link.b) for link in links} == ends
    friction = {name: CATALOGUE[f"{name}_friction"].params for name in ("nut", "anchor", "free")}
    into = [link for link in links if (link.a, link.b) == ("screw", START)]
    total = np.array([np.sum(link.g * link.over + 0.0 * u.coverage, axis=1) for link in into])
    for w, tick in ((0.0, 0), (1 / 3, 1), (1.0, 2)):
        for k, (name, rate) in enumerate((("nut", 0.02), ("anchor", 0.03), ("free", 0.03))):
            less = rate * np.exp(-10.0 * rate) * friction[name]["power"].value * w ** friction[name]["n"].value
            assert total[k, tick] == pytest.approx(less, rel=1e-9)
    (body,) = (link.g for link in links if link.a == "nut")
    less = 0.02 * np.exp(-0.2) * friction["nut"]["power_nut"].value
    np.testing.assert_allclose(body[:, 0], less * u.omega[:, 0] / REFERENCE)


@pytest.mark.parametrize(("rate", "g", "share"), [(0.01, 3.0, 0.99), (0.08, 3.0, 0.89), (0.03, 0.0, 0.0)])
def test_what_rubs_is_as_warm_as_both_sides(rate, g, share, full, rig, u):
    """Friction of equal powers falls by slope (T_screw + T_nut) / 2 on either side; a link never conducts backwards."""
    model = full + CATALOGUE["friction_thinning"]
    powers = {"nut_friction.power": 60.0, "nut_friction.power_nut": 60.0}
    terms = model.with_values({**powers, "nut_body.g": g, "friction_thinning.rate": rate}).terms_of(
        "friction_thinning", u, rig
    )
    linked = sum(np.sum(term.g * term.over, axis=1) for term in terms if isinstance(term, Link) and term.b == "nut")
    half = 0.5 * 60.0 * rate * np.exp(-10.0 * rate) * u.omega[:, 0] / REFERENCE
    assert np.all((-g / 2 <= linked) & (linked <= 0.0))
    np.testing.assert_allclose(linked[2], -half[2] * share, rtol=0.02)


def test_warm_grease_thins_at_nut_and_bearings_by_rates_of_their_own(rig, u):
    """With the rates of friction_thinning its terms are those."""
    little = terms_of("warm_grease", rig, u, nut=0.02, bearings=0.03)
    for mine, strong in zip(little, terms_of("friction_thinning", rig, u, rate=0.02, ratio=1.5), strict=True):
        assert type(mine) is type(strong)
        np.testing.assert_allclose(*(t.g if isinstance(t, Link) else t.q for t in (mine, strong)), rtol=1e-12)


@pytest.mark.parametrize(("start", "within"), [(30.0, 1e-9), (20.0, 0.04), (40.0, 0.07)])
def test_friction_is_that_of_an_exponential_where_machines_work(start, within, rig, u):
    """Of the nut's body, where it starts: what is left of P w^n, e^(-rate (T - T_ref)) of it, exactly 10 K above."""
    there = replace(u, values={**u.values, START: np.full_like(u.omega, start)})
    terms = terms_of("friction_thinning", rig, there, rate=0.03, reference=20.0)
    friction = CATALOGUE["nut_friction"].params["power_nut"].value * u.omega[:, 0] / REFERENCE
    left = friction + watts(terms, "nut", 3)
    np.testing.assert_allclose(left, friction * np.exp(-0.03 * (start - 20.0)), rtol=within)


def test_thinning_serves_a_model_without_bearings_and_bodies(full, rig, u):
    bare = full
    for name in (
        "nut_flange", "nut_body", "housing_shells", "anchor_housing", "free_housing", "anchor_friction", "free_friction"
    ):  # fmt: skip
        bare = bare - name
    model = bare + CATALOGUE["friction_thinning"]
    link, heat = model.terms_of("friction_thinning", u, rig)
    assert (link.a, link.b, heat.node) == ("screw", START, "screw")
    assert all(finding.ok for finding in battery(CATALOGUE["friction_thinning"], bare, rig))


def test_churning_fades_with_ten_minutes_of_motion(rig):
    u = moving(rig, np.full(1800, REFERENCE))
    terms = terms_of("churning", rig, u, share=0.5)
    for node, power in (("screw", 60.0), ("nut", 50.0)):
        expected = 0.5 * power * np.exp(-np.arange(1, 1801) / 600)
        np.testing.assert_allclose(watts(terms, node, 1800), expected, rtol=1e-9)


def test_churning_comes_back_at_rest(rig):
    """A drive of ten minutes, a stop of fifteen: what had gone has come back but for 1/e."""
    u = moving(rig, np.repeat([REFERENCE, 0.0, REFERENCE], [600, 900, 5]))
    heat = watts(terms_of("churning", rig, u, share=0.5), "screw", 1505)
    assert (heat[600:1500] == 0).all()
    fresh = 1 - (1 - np.exp(-1)) * np.exp(-1)
    assert heat[1500] == pytest.approx(0.5 * 60 * fresh * np.exp(-1 / 600), rel=1e-9)


@pytest.mark.parametrize("name", ["nut_speed_exponent", "churning", "friction_thinning"])
def test_what_an_effect_scales_must_be_there(name, full, rig, u):
    model = without(full, "nut_friction", rig) + CATALOGUE[name]
    with pytest.raises(SetupError, match=rf"^full: {name}: needs the effect 'nut_friction', .* add it first$"):
        list(model.terms_of(name, u, rig))


def test_what_scales_an_effect_moves_with_it(every):
    assert set(every.moved_by("nut_friction")) == {
        "nut_friction",
        "nut_speed_exponent",
        "friction_thinning",
        "warm_grease",
        "churning",
    }
    assert set(every.moved_by("still_air")) == {"still_air", "free_convection"}


# --- places


@pytest.mark.parametrize("at", [35.0, 400.0, 701.3])
def test_local_heat_puts_in_its_power_around_its_place(at, rig, u):
    for name, driving in (("local_heat", [1, 1, 1]), ("local_heat_driving", [0, 1, 1])):
        (heat,) = terms_of(name, rig, u, power=3.0, at=at, width=40.0)
        np.testing.assert_allclose(watts([heat], "screw", 3), 3.0 * np.array(driving))
        assert heat.over @ rig.screw.x_mm == pytest.approx(at, abs=0.5)
        assert np.sqrt(heat.over @ (rig.screw.x_mm - at) ** 2) == pytest.approx(40 / np.sqrt(12), rel=0.02)


def test_the_motor_warms_its_own_end_while_driving(rig, u):
    (heat,) = terms_of("motor_heat", rig, u, power=12.0)
    np.testing.assert_allclose(watts([heat], "screw", 3), [0, 12, 12])
    assert heat.over @ rig.screw.x_mm == pytest.approx(rig.screw.to_mm - 20, abs=2)
    other = replace(rig, supports={**rig.supports, "anchor": replace(rig.supports["anchor"], at_mm=0.0)})
    (heat,) = terms_of("motor_heat", other, u)
    assert heat.over @ rig.screw.x_mm == pytest.approx(rig.screw.from_mm + 20, abs=2)


# --- surroundings


def test_radiation_is_still_air_of_four_eps_sigma_t3(rig, u):
    (radiation,) = terms_of("radiation", rig, u, emissivity=0.6)
    (still,) = terms_of("still_air", rig, u, h=4 * 0.6 * STEFAN_BOLTZMANN * 295**3)
    assert (radiation.a, radiation.b) == (still.a, still.b)
    assert radiation.g == pytest.approx(still.g, rel=1e-4)


def test_the_surroundings_drift_by_the_clock(rig, u):
    shifts = terms_of("base_drift", rig, u, rate=2.0)
    assert [shift.input for shift in shifts] == ["ambient", "base"]
    for shift in shifts:
        np.testing.assert_allclose(shift.by[:, 0], 2.0 * np.array([900, 901, 902]) / 3600)
    inputs = {name: signal for name, signal in rig.inputs.items() if name != "base"}
    u = no_inputs(replace(rig, inputs=inputs), u.omega, u.coverage)
    assert [shift.input for shift in terms_of("base_drift", replace(rig, inputs=inputs), u)] == ["ambient"]


def test_shifted_air_is_air_of_another_temperature(full, rig, driven):
    """3 K/h of drift, and the same in the air's and the base's own thermometers."""
    drive = driven(rig, 300, (10, 200), FAST)
    drift = 3.0 * np.arange(300) / 3600
    warmer = {**drive.inputs, "ambient": 22 + drift, "base": 22 + drift}
    there = open_loop(full, rig, replace(drive, inputs=warmer))
    model = (full + CATALOGUE["base_drift"]).with_values({"base_drift.rate": 3.0})
    np.testing.assert_allclose(open_loop(model, rig, drive), there, rtol=0, atol=1e-9)
    assert abs(there - open_loop(full, rig, drive)).max() > 0.01


def test_a_gradient_is_none_in_the_middle_and_half_at_the_outer_thermometers(rig, u):
    (shift,) = terms_of("ambient_gradient", rig, u, difference=4.0)
    assert isinstance(shift, Shift)
    assert shift.input == "ambient"
    places = [rig.channels[name].at_mm for name in rig.thermometers]
    at = [
        rig.screw.at(x) @ (shift.by * shift.over) for x in (min(places), (min(places) + max(places)) / 2, max(places))
    ]
    np.testing.assert_allclose(at, [-2.0, 0.0, 2.0], atol=1e-9)


@pytest.mark.parametrize("name", ["still_air", "rotating_convection", "radiation"])
def test_neither_nut_nor_bearing_lets_the_screw_lose_heat_to_the_air(name, rig, u):
    """As if the screw were shorter by the nut and both seats; they lie inside the screw, and apart."""
    (link,) = terms_of(name, rig, u)
    (whole,) = terms_of(name, rig, replace(u, coverage=np.zeros_like(u.coverage), seats=0.0))
    loss, bare = (np.broadcast_to(each.g * each.over, (3, rig.screw.cells)).sum(axis=1) for each in (link, whole))
    hidden_mm = rig.nut.length_mm + sum(each.width_mm for each in rig.supports.values())
    np.testing.assert_allclose(loss, bare * (1 - hidden_mm / (rig.screw.to_mm - rig.screw.from_mm)), rtol=1e-9)


def test_a_gradient_warms_one_end_as_it_cools_the_other(rig, u):
    """A bare bar that only loses heat to the air: what a gradient gives sums up to nothing about its middle."""
    u = replace(u, coverage=np.zeros_like(u.coverage), seats=0.0)
    terms = [*terms_of("still_air", rig, u), *terms_of("ambient_gradient", rig, u), *terms_of("conduction", rig, u)]
    place = layout(terms, rig, reduced=False)
    network = assemble.network_of(terms, place, 3)
    outside = np.zeros((3, place.boundaries))
    outside[:, len(place.inputs) :] = assemble.outside(terms, u, place)[:, len(place.inputs) :]
    gained = np.einsum("tij,tj->ti", network.inflow, outside)[0]
    places = [rig.channels[name].at_mm for name in rig.thermometers]
    middle = (min(places) + max(places)) / 2
    left, right = ((rig.screw.x_mm - middle) * side > 0 for side in (-1, 1))
    reach = min(middle - rig.screw.from_mm, rig.screw.to_mm - middle)
    near = abs(rig.screw.x_mm - middle) < reach
    assert gained[left & near].sum() == pytest.approx(-gained[right & near].sum(), rel=0.02)
    assert gained[right].sum() > 0.05


def test_a_shift_is_felt_by_what_links_to_its_input_only(rig, u):
    """The nut's own link to the air feels a drift of the air, but no gradient along the screw; the base feels none."""
    links = [Link("nut", "ambient", 2.0), Link("nut", "base", 3.0)]
    stores = terms_of("nut_body", rig, u)[:1]
    for shift, felt in ((Shift("ambient", 1.5), 2.0), (Shift("ambient", 1.5, over=rig.screw.x_mm), 0.0)):
        terms = [*stores, *links, shift]
        place = layout(terms, rig)
        inflow = assemble.network_of(terms, place, 3).inflow
        np.testing.assert_allclose(inflow[:, 0, len(place.inputs)], felt)
        np.testing.assert_allclose(assemble.outside(terms, u, place)[:, -1], 1.5)


@pytest.mark.parametrize("support", ["anchor", "free"])
def test_a_seat_moves_and_widens_where_friction_enters_and_heat_leaves(support, full, rig, u):
    seated = full + CATALOGUE[f"{support}_seat"]
    moved = seated.with_values({f"{support}_seat.shift": 3.0, f"{support}_seat.width": 1.5})

    def entering(model):
        heats = [*model.terms_of(f"{support}_friction", u, rig), *model.terms_of(f"{support}_housing", u, rig)]
        return [share for term in heats for share in (getattr(term, "over", None), getattr(term, "g", None))
                if np.shape(share) == (rig.screw.cells,)]  # fmt: skip

    for usual, same, other in zip(entering(full), entering(seated), entering(moved), strict=True):
        np.testing.assert_array_equal(same, usual)
        assert other.sum() == pytest.approx(usual.sum(), rel=1e-12)
        middle, wide = (np.average(rig.screw.x_mm, weights=share) for share in (usual, other))
        assert wide - middle == pytest.approx(3.0, abs=0.1)
        spread, wider = (np.sqrt(np.average((rig.screw.x_mm - at) ** 2, weights=share))
                         for at, share in ((middle, usual), (wide, other)))  # fmt: skip
        assert wider / spread == pytest.approx(1.5, rel=0.02)
    assert len(entering(full)) == 2
