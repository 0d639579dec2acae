"""What the reduced mesh and the regimes cost: against 500 cells, and against a regime of its own for every tick."""

from dataclasses import replace
from unittest import mock

import numpy as np
import pytest
from scipy.sparse import csc_matrix, diags_array
from scipy.sparse.linalg import splu

from estimator.filter import Filter
from estimator.inputs.start import Start
from estimator.network import assemble, mesh, regime
from estimator.network.forcing import Forcing
from estimator.network.layout import Layout
from estimator.rig import Channel, Rig, Signal
from estimator.rig_folder.model_toml import load_model
from estimator.screw import Nut, Screw
from estimator.state.open_loop import OpenLoop

STEPS = 20  # of the fine integration in a tick
RUNS = {
    "FS-20": ((20, 242), 174.5, (0.0, 400.0)),
    "ES-20": ((20, 420), 174.5, (202.0, 315.0)),
    "FS-2.5": ((20, 425), 21.8, (0.0, 400.0)),
}


def start(rig) -> Start:
    return Start(22.0, 0.0, dict.fromkeys(rig.inputs, 0.0))


def reduced(model, rig, drive):
    """What the channels would read without lag, (K, m), on the filter's own mesh; and how many regimes it took."""
    forcing = Forcing(model, rig, start(rig))
    run, out = OpenLoop(np.full(forcing.place.size, 22.0), forcing.readings, rig.tick_s), []
    for begin in range(0, len(drive), 25):
        ticks = forcing.ticks(forcing.read(drive.rows(slice(begin, begin + 25))))
        for r, heat in zip(ticks.regime, ticks.heat, strict=True):
            run.step(forcing.transition(r), heat)
            out.append(forcing.readings.rows @ run.z)
    return np.array(out), int(max(ticks.regime)) + 1


def by_cells(place, node, weights, regimes, other=""):
    """Layout.squares where every cell is a state: no product of two is to be summed over cells, but of those linked."""
    if other:
        rows = place.rows(node)
        rows = rows[:-1] - rows[1:] if node == other else rows - place.rows(other)
        return (rows.T * np.broadcast_to(weights, (regimes, len(rows)))[:, None, :]) @ rows
    (cells, states), found = np.nonzero(place.rows(node)), np.zeros((regimes, place.size, place.size))
    assert (place.rows(node)[cells, states] == 1.0).all()
    found[:, states, states] = weights
    return found


@mock.patch.object(Layout, "squares", by_cells)
def fine(model, rig, drive):
    """The same on every cell: the network of each regime, solved implicitly (trapezoids, 20 steps a tick)."""
    forcing = Forcing(model, rig, start(rig), reduced=False)
    read = forcing.read(drive)
    place, terms = forcing.place, list(model.terms(read.inputs, rig))
    outside = assemble.outside(terms, read.inputs, place)
    heat, dt = assemble.heat(terms, place, len(drive)), rig.tick_s / STEPS
    solvers: dict[int, tuple] = {}
    z, out = np.full(place.size, 22.0), []
    for r, q, air in zip(read.regime, heat, outside, strict=True):
        if r not in solvers:
            u = forcing.regime_inputs([r])
            network = assemble.network_of(list(model.terms(u, rig)), place, len(u))
            mass, g = diags_array(np.diag(network.mass)).tocsc(), csc_matrix(network.conductance[0])
            solvers[r] = splu(mass + dt / 2 * g), mass - dt / 2 * g, network.inflow[0]
        ahead, behind, inflow = solvers[r]
        for _ in range(STEPS):
            z = ahead.solve(behind @ z + dt * (q + inflow @ air))
        out.append(forcing.readings.rows @ z)
    return np.array(out)


@pytest.mark.parametrize("name", RUNS)
def test_reduced_mesh_agrees_with_500_cells(name, full, rig, driven):
    when, omega, stroke = RUNS[name]
    exact = replace(rig, screw=replace(rig.screw, cells=500))
    true = fine(full, exact, driven(exact, 500, when, omega, stroke))
    ours, _ = reduced(full, rig, driven(rig, 500, when, omega, stroke))
    error = abs(ours - true).max(axis=0)
    assert true[:, 15].max() - true[0, 15] > 10
    assert error[15] <= 0.05
    assert error[:15].max() <= 0.1


def test_a_seat_of_half_the_width_is_told_too(rig, driven):
    """Thermometers to 0.05 K, which were 0.24 K off, and the growth to 0.015 um of 0.05."""
    narrow = {"anchor_seat.width": 0.55, "free_seat.width": 0.5, "thermometers.bore": 0.0}
    model = load_model(rig.folder / "model.toml").with_values(narrow)
    exact = replace(rig, screw=replace(rig.screw, cells=540))
    drive = driven(rig, 250, *RUNS["FS-20"])
    error = abs(reduced(model, rig, drive)[0] - fine(model, exact, driven(exact, 250, *RUNS["FS-20"]))).max(axis=0)
    assert error[:15].max() <= 0.07
    assert error[15] <= 0.025


def test_the_filter_has_at_most_32_states_that_move(full, rig, driven, live):
    filter_ = Filter(full, rig)
    filter_.step(live(full, rig, driven(rig, 1)).recording.sample(0))
    state = filter_.run.state
    assert state.n <= 32
    assert filter_.fusion.x.shape == (state.size,)
    assert state.size == state.n + len(state.zero_of) + 2  # constants cost little


def cost_of_regimes(model, rig, drive, monkeypatch) -> tuple[float, float, int]:
    """Most that regimes cost the displacement (um) and a thermometer (K), and how many there were.

    Against conductances that follow speed and coverage in every tick.
    """
    ours, few = reduced(model, rig, drive)
    with monkeypatch.context() as exact:
        exact.setattr(regime, "SPEED_STEP", 1e-12)
        exact.setattr(regime, "COVERAGE_STEP", 1e-12)
        exact.setattr(regime, "WINDOW_S", rig.tick_s)
        true, many = reduced(model, rig, drive)
    assert many > (drive.omega > 0).sum()
    error = abs(ours - true).max(axis=0)
    assert error[15] > 0
    return error[15], error[:15].max(), few


@pytest.mark.parametrize(("name", "um", "kelvin"), [("FS-2.5", 0.005, 0.003), ("FS-20", 0.04, 0.03)])
def test_what_regimes_cost(name, um, kelvin, full, rig, driven, monkeypatch):
    """0.003 and 0.032 um in 330 s."""
    _, omega, stroke = RUNS[name]
    error, warmer, few = cost_of_regimes(full, rig, driven(rig, 330, (10, 270), omega, stroke), monkeypatch)
    assert error < um
    assert warmer < kelvin
    assert few <= 40


@pytest.mark.parametrize(("name", "um", "kelvin"), [("ES-20", 0.045, 0.055), ("FS-20", 0.12, 0.17)])
def test_what_regimes_cost_the_shipped_model_in_a_longer_drive(name, um, kelvin, rig, driven, monkeypatch):
    """0.034 and 0.091 um: a nut that gives more heat to the screw feels more where it is."""
    _, omega, stroke = RUNS[name]
    drive = driven(rig, 500, (10, 440), omega, stroke)
    error, warmer, few = cost_of_regimes(load_model(rig.folder / "model.toml"), rig, drive, monkeypatch)
    assert error < um
    assert warmer < kelvin
    assert few <= 40


def test_shapes_are_one_at_their_knot_and_sum_to_one():
    places = np.array([0.0, 40, 90, 200])
    np.testing.assert_allclose(mesh.shapes(places, places), np.eye(4), atol=1e-12)
    np.testing.assert_allclose(mesh.shapes(places, np.linspace(0, 200, 77)).sum(axis=1), 1, atol=1e-12)


def test_shapes_follow_any_cubic_up_to_the_ends():
    """Also one that is steep at an end, as where a bar is chilled there."""
    places, x = np.array([0.0, 40, 90, 140, 200]), np.linspace(0, 200, 50)
    cubic = np.polynomial.Polynomial([3.0, -0.2, 2e-3, -7e-6])
    np.testing.assert_allclose(mesh.shapes(places, x) @ cubic(places), cubic(x), atol=1e-9)


def test_knots_stand_at_thermometers_bearings_and_ends(rig):
    knots = mesh.knots(rig)
    assert (np.diff(knots) > 0).all()
    assert (np.diff(knots) <= mesh.WIDEST_MM + 1e-9).all()
    wanted = [c.at_mm for c in rig.channels.values() if c.at_mm is not None]
    for place in [*wanted, -50.0, 1030.0, 72.5, 889.0]:
        assert abs(knots - place).min() < 1e-9


def test_chosen_knots_are_kept_and_a_bare_bar_has_some():
    bar = Rig("bar", 1.0, {"A": Channel(at_mm=100.0)}, {"ambient": Signal()}, Screw(0, 300, 20), Nut(10, 0))
    assert list(mesh.knots(bar)) == [0, 50, 100, *(100 + 200 / 3 * np.array([1, 2, 3]))]
    chosen = replace(bar, screw=replace(bar.screw, knots_mm=(300.0, 0.0, 120.0)))
    assert list(mesh.knots(chosen)) == [0, 120, 300]
