"""Terms into matrices, and matrices into one tick: heat is kept, and the discretisation is exact."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from estimator.effect import Effect
from estimator.errors import SetupError
from estimator.inputs.inputs import Inputs, no_inputs
from estimator.inputs.start import Start
from estimator.model import model_of
from estimator.network import assemble
from estimator.network.check import checked_terms
from estimator.network.discretise import Modes, transition
from estimator.network.forcing import Forcing
from estimator.network.layout import layout
from estimator.terms import ELONGATION, Chain, Heat, Link, Read, Spot, Store


class Insulated(Effect):
    """A bar and two bodies that exchange heat among each other only: g (T_a - T_b)."""

    def terms(self, p, u, rig):
        yield Store("b", 300.0, 0.5)
        yield Store("a", 200.0, 0.5)
        yield Store("screw", np.linspace(20, 30, rig.screw.cells), 0.1)
        yield Chain("screw", np.linspace(3, 5, rig.screw.cells - 1))
        yield Link("screw", "a", u.coverage)
        yield Link("b", "screw", np.linspace(0, 1, rig.screw.cells))
        yield Link("a", "b", 2.0)
        yield Heat("screw", u.omega * u.coverage, noise=0.1 * u.coverage)


class Leaking(Effect):
    """The bar and one body of `insulated` lose heat to the air: g (T - T_air)."""

    def terms(self, p, u, rig):
        yield Link("screw", "ambient", np.linspace(0.1, 0.2, rig.screw.cells))
        yield Link("ambient", "a", 0.7)


def two_regimes(rig) -> Inputs:
    coverage = rig.screw.overlap(np.array([20.0, 90.0]), np.array([70.0, 140.0]))
    return no_inputs(rig, np.array([[0.0], [100.0]]), coverage)


def assembled(rig, *effects, reduced: bool = True):
    model, u = model_of(effects), two_regimes(rig)
    place = layout(list(model.terms(u, rig)), rig, reduced)
    return place, assemble.network_of(list(model.terms(u, rig)), place, len(u))


@pytest.fixture(scope="module", params=[True, False], ids=["reduced", "cells"])
def insulated(request, small):
    return assembled(small, Insulated, reduced=request.param)


def test_links_and_chains_only_move_heat(insulated):
    _, network = insulated
    np.testing.assert_allclose(network.conductance.sum(axis=1), 0, atol=1e-12)
    np.testing.assert_allclose(network.conductance, network.conductance.transpose(0, 2, 1), atol=1e-12)
    assert abs(network.conductance).max() > 1


def test_total_heat_is_constant_without_a_boundary(insulated):
    place, network = insulated
    z = 20 + np.random.default_rng(1).standard_normal(place.size)
    total = network.mass.sum(axis=0)
    assert total.sum() == pytest.approx(300 + 200 + 20 * 25)
    for regime in (0, 1):
        moved = transition(network, regime, 7.0)
        assert total @ moved.F @ z == pytest.approx(total @ z, rel=1e-12)
        np.testing.assert_allclose(total @ moved.J, 7.0, rtol=1e-9)


def test_what_leaves_the_network_leaves_through_the_boundaries(small):
    place, network = assembled(small, Insulated, Leaking, reduced=False)
    assert (place.inputs, place.boundaries) == (("ambient",), 1)
    np.testing.assert_allclose(network.conductance.sum(axis=1), network.inflow[:, :, 0], atol=1e-12)
    np.testing.assert_allclose(network.inflow.sum(axis=(1, 2)), 20 * 0.15 + 0.7)


def test_all_at_the_air_s_temperature_is_at_rest(small):
    _, network = assembled(small, Insulated, Leaking)
    np.testing.assert_allclose(network.conductance.sum(axis=2), network.inflow.sum(axis=2), atol=1e-12)


def test_one_body_cools_as_the_formula_says(small):
    class Cup(Effect):
        """C dT/dt = -g (T - T_air)."""

        def terms(self, p, u, rig):
            yield Store("cup", 50.0, 3.0)
            yield Link("cup", "ambient", 2.0)

    _, network = assembled(small, Cup)
    moved = transition(network, 0, 10.0)
    keep = np.exp(-2 * 10 / 50)
    assert moved.F[0, 0] == pytest.approx(keep, rel=1e-12)
    assert moved.J[0, 0] == pytest.approx((1 - keep) / 2, rel=1e-12)
    assert moved.Q[0, 0] == pytest.approx((3 / 50) ** 2 * (1 - keep**2) * 50 / (2 * 2), rel=1e-12)


def test_discretisation_equals_its_integrals(small):
    """F = e^(A dt);   J = integral of e^(A s) M^-1;   Q = integral of e^(A s) W e^(A's), by Gauss-Legendre."""
    _, network = assembled(small, Insulated, Leaking)
    inverse = np.linalg.inv(network.mass)
    nodes, weights = np.polynomial.legendre.leggauss(30)
    dt = 4.0
    for regime in (0, 1):
        A = -inverse @ network.conductance[regime]
        W = inverse @ network.noise[regime] @ inverse.T
        ways = [expm(A * dt * (node + 1) / 2) for node in nodes]
        moved = transition(network, regime, dt)
        J = sum(w * dt / 2 * way @ inverse for w, way in zip(weights, ways, strict=True))
        Q = sum(w * dt / 2 * way @ W @ way.T for w, way in zip(weights, ways, strict=True))
        np.testing.assert_allclose(moved.F, expm(A * dt), rtol=0, atol=1e-12)
        np.testing.assert_allclose(moved.J, J, rtol=0, atol=1e-12 * abs(J).max() * 10)
        np.testing.assert_allclose(moved.Q, Q, rtol=0, atol=1e-12 * abs(Q).max() * 10)
        assert np.linalg.eigvalsh(moved.Q).min() > 0


def test_many_short_ticks_make_a_long_one(small):
    """Also where a mode dies out within the tick: 600 s against 600 times 1 s."""
    _, network = assembled(small, Insulated, Leaking, reduced=False)
    short, long = transition(network, 1, 1.0), transition(network, 1, 600.0)
    F, J, Q = np.eye(22), np.zeros((22, 22)), np.zeros((22, 22))
    for _ in range(600):
        F, J, Q = short.F @ F, short.F @ J + short.J, short.F @ Q @ short.F.T + short.Q
    for whole, parts in ((long.F, F), (long.J, J), (long.Q, Q)):
        np.testing.assert_allclose(whole, parts, rtol=0, atol=1e-9 * abs(parts).max())
    assert np.linalg.eigvalsh(long.Q).min() > 0


def test_noise_of_a_heat_is_in_step_over_all_cells(small):
    place, network = assembled(small, Insulated, reduced=False)
    coverage = two_regimes(small).coverage
    cells = place.nodes["screw"]
    expected = 0.01 * np.outer(coverage[1], coverage[1]) + 0.01 * np.eye(20)
    np.testing.assert_allclose(network.noise[1][cells, cells], expected, atol=1e-15)
    assert network.noise[1][place.nodes["a"], place.nodes["a"]] == 0.25


def test_all_heat_arrives_on_the_reduced_mesh(small):
    u, model = two_regimes(small), model_of([Insulated])
    terms = list(model.terms(u, small))
    place = layout(terms, small)
    np.testing.assert_allclose(assemble.heat(terms, place, 2).sum(axis=1), [0, 100 * 5.0])


def test_boundaries_push_with_their_own_temperature(small, driven):
    """At rest, everything at 22 degC with air at 30: heat flows in by each link's conductance."""
    drive = driven(small, 3, (9, 9))
    drive = replace(drive, inputs={**drive.inputs, "ambient": np.full(3, 30.0)})
    forcing = Forcing(model_of([Insulated, Leaking]), small, Start(22.0, 0.0, dict.fromkeys(small.inputs, 0.0)))
    ticks = forcing.ticks(forcing.read(drive))
    np.testing.assert_allclose(ticks.heat.sum(axis=1), 30 * (20 * 0.15 + 0.7))


def only_spare(spare: bool) -> type[Effect]:
    class Warmer(Effect):
        """A heat into a node that may not be there: q = 7 W."""

        def terms(self, p, u, rig):
            yield Heat("pot", 7.0, noise=0.5, spare=spare)

    return Warmer


class Pot(Effect):
    """A pot that cools in the air: C dT/dt = q - g (T - T_air)."""

    def terms(self, p, u, rig):
        yield Store("pot", 50.0, 0.1)
        yield Link("pot", "ambient", 2.0)


def test_spare_heat_leaves_where_no_effect_stores_its_node(small):
    place, alone = assembled(small, Insulated)
    same, network = assembled(small, Insulated, only_spare(True))
    assert same.nodes == place.nodes
    np.testing.assert_array_equal(network.noise, alone.noise)
    u = two_regimes(small)
    heats = [
        assemble.heat(list(model_of(effects).terms(u, small)), place, 2)
        for effects in ((Insulated,), (Insulated, only_spare(True)))
    ]
    np.testing.assert_array_equal(*heats)


@pytest.mark.parametrize("spare", [True, False])
def test_spare_heat_arrives_where_its_node_is_stored(spare, small):
    u, model = two_regimes(small), model_of([Pot, only_spare(spare)])
    terms = checked_terms(model, u, small)
    place, network = assembled(small, Pot, only_spare(spare))
    np.testing.assert_array_equal(assemble.heat(terms, place, 2), [[7.0], [7.0]])
    np.testing.assert_allclose(network.noise[:, 0, 0], 0.1**2 + 0.5**2)


def test_heat_that_is_not_spare_needs_its_node(small):
    with pytest.raises(SetupError, match=r"warmer: a Heat is in 'pot', which no effect of the model stores"):
        checked_terms(model_of([Insulated, only_spare(False)]), two_regimes(small), small)
    assert checked_terms(model_of([Insulated, only_spare(True)]), two_regimes(small), small)


class Probe(Effect):
    """The displacement reads the growth, and one thermometer the bar: y = X."""

    def terms(self, p, u, rig):
        yield Read("displacement", {ELONGATION: 1.0}, 0.3, 2.0, zero_sd=3.0, zero_walk=0.03)
        yield Read("T1", {"screw": rig.screw.at(5.0)}, 0.02)


class Holder(Effect):
    """The probe's holder leans: y = -0.25 T_a + 0.5 X."""

    def terms(self, p, u, rig):
        yield Read("displacement", {"a": -0.25, ELONGATION: 0.5}, 0.4, u.rise("probe"), zero_sd=4.0, zero_walk=0.04)


def test_several_reads_of_a_channel_add(small):
    """Weights and offsets as they are, scatter and unknown zeros in squares; other channels stay as they were."""
    u = two_regimes(small)
    u = replace(u, rises={**u.rises, "probe": np.array([[0.0], [1.5]])})
    terms = checked_terms(model_of([Insulated, Probe, Holder]), u, small)
    place = layout(terms, small)
    found = assemble.readings(terms, small, place)
    growth = small.screw.growth(10.0, 190.0) @ place.shapes[:20]
    expected = 1.5 * growth
    expected[place.state("a")] -= 0.25
    np.testing.assert_allclose(found.rows[4], expected, rtol=1e-12)
    np.testing.assert_array_equal(found.spans, [0, 0, 0, 0, 1.5])
    assert (found.sd[4], found.zero_sd[4], found.zero_walk[4]) == pytest.approx((0.5, 5.0, 0.05))
    np.testing.assert_array_equal(assemble.offsets(terms, small, 2)[:, 4], [2.0, 3.5])
    alone = assemble.readings(checked_terms(model_of([Insulated, Probe]), u, small), small, place)
    np.testing.assert_array_equal(found.rows[:4], alone.rows[:4])
    np.testing.assert_array_equal(found.sd[:4], [0.02, np.inf, np.inf, np.inf])


class Wall(Effect):
    """A thermometer that follows what is beside it more than the mean of its section does."""

    def terms(self, p, u, rig):
        yield Read("T1", {"screw": Spot(80.0, 2.0, deep=30.0)}, 0.02)
        yield Read("displacement", {ELONGATION: 1.0}, 0.3)


@pytest.mark.parametrize("reduced", [True, False], ids=["reduced", "cells"])
def test_a_deep_spot_reads_how_the_profile_bends(reduced, small):
    """T = ((x - 70) / 10)^2 reads w (T + deep T''), T'' = 0.02 K/mm2."""
    fine = replace(small, screw=replace(small.screw, cells=200))
    place, _ = assembled(fine, Insulated, Wall, reduced=reduced)
    row = assemble.readings(checked_terms(model_of([Insulated, Wall]), two_regimes(fine), fine), fine, place).rows[0]
    x_mm = place.knots_mm if reduced else fine.screw.x_mm
    T = np.append(((x_mm - 70.0) / 10.0) ** 2, [0.0] * len(place.bodies))
    assert row @ T == pytest.approx(2.0 * (1.0 + 30.0 * 0.02), abs=0.01)
    assert row.sum() == pytest.approx(2.0)


@pytest.mark.parametrize("effects", [(Insulated, Leaking), (Insulated,)], ids=["leaking", "with a mode that stays"])
def test_derivatives_of_a_tick_are_those_of_differences(small, effects):
    """How F and J move along random symmetric directions, by 4th-order differences; equal rates included."""
    _, network = assembled(small, *effects)
    rng, n, dt = np.random.default_rng(2), len(network.mass), 5.0
    for name in ("mass", "conductance"):
        way = rng.standard_normal((n, n))
        way = (way + way.T) * abs(getattr(network, name)).max() * 1e-3
        moved = [replace(network, **{name: getattr(network, name) + k * 1e-2 * way}) for k in (2, 1, -1, -2)]
        two, one, less, lesser = (transition(other, 1, dt) for other in moved)
        found = Modes(network, 1, dt).along(**{"mass": np.zeros((n, n)), "conductance": np.zeros((n, n)), name: way})
        for slope, key in zip(found, "FJ", strict=True):
            far = [getattr(each, key) for each in (two, one, less, lesser)]
            expected = (-far[0] + 8 * far[1] - 8 * far[2] + far[3]) / 0.12
            np.testing.assert_allclose(slope, expected, rtol=0, atol=1e-7 * abs(expected).max(), err_msg=name)


def test_a_derivative_by_the_noise_of_a_tick_is_that_by_its_covariance(small):
    """Q is linear in the noise: <g, Q(W)> = <slope(g), W>."""
    _, network = assembled(small, Insulated, Leaking)
    rng, n = np.random.default_rng(2), len(network.mass)
    g, way = rng.standard_normal((n, n)), rng.standard_normal((n, n))
    noise = np.broadcast_to(way @ way.T, network.noise.shape)
    Q = transition(replace(network, noise=noise), 1, 5.0).Q
    slope = Modes(network, 1, 5.0).noise_slope(g + g.T)
    assert (slope * noise[1]).sum() == pytest.approx(((g + g.T) * Q).sum(), rel=1e-9)
