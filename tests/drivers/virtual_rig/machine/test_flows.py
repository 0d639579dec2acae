"""The virtual rig's heat against exact solutions, its own balance and finer steps."""

import math

import numpy as np
import pytest

from drivers.virtual_rig import simulate
from drivers.virtual_rig.machine import flows, heat, screw
from drivers.virtual_rig.machine.planted import BASE, PLANTED
from drivers.virtual_rig.population.constants import PAPER
from drivers.virtual_rig.population.draw import machine


def test_layers_keep_the_bore_as_far_behind_as_the_cylinder_would():
    steel = screw.steel(PAPER.screw, conduction=1.0)
    bore, outer = np.full(screw.CELLS, 20.0), np.full(screw.CELLS, 20.0)
    flux, mean_above_bore = 118.0, screw.mean_above_bore(PAPER.screw.conductivity)
    for _ in range(600):
        flows.spread(steel, bore, outer, np.full(screw.CELLS, flux * screw.CELL_M), 0.05)
    behind = screw.mean_temperature(bore, outer) - bore
    assert behind == pytest.approx(mean_above_bore * flux, rel=1e-4)
    assert mean_above_bore * flux == pytest.approx(0.053, abs=0.001)


@pytest.mark.parametrize("growth", [0.0, 0.25])
def test_still_air_takes_more_of_what_is_warmer(growth):
    """As much as in proportion at the rise it is computed for, of each place by its own warmth."""
    parts = heat.parts(PAPER, dict.fromkeys(BASE, 1.0) | dict.fromkeys(PLANTED, 0.0))
    rise, heats = np.linspace(0.5, 12.0, screw.CELLS), np.zeros(screw.CELLS)
    surface, along = parts.surface._replace(growth=growth), np.full(screw.CELLS, 20.0)
    flows.cool(surface, 0.0, along + rise, np.zeros(screw.CELLS), along, heats)
    exact = surface.still * (rise / surface.rise) ** growth * rise * surface.area
    np.testing.assert_allclose(heats, -exact, rtol=1e-12)


@pytest.mark.parametrize("number", [0, 1, 2, 3, 4])
def test_friction_heat_is_neither_lost_nor_made(number):
    """With every way out closed, screw, nut and housings hold what the torques have put in."""
    base = dict.fromkeys(BASE, 1.0) | dict.fromkeys(PLANTED, 0.0)
    parts = heat.parts(machine(number), base | {"still_air": 0.0, "rotating_convection": 0.0})
    tight = parts._replace(
        nut=parts.nut._replace(to_table=0.0),
        anchor=parts.anchor._replace(to_base=0.0, to_air=0.0),
        free=parts.free._replace(to_base=0.0, to_air=0.0),
        surface=parts.surface._replace(emissivity=0.0),
    )
    now = flows.Temperatures(
        np.full(screw.CELLS, 20.0), np.full(screw.CELLS, 20.0), np.array([20.0, 20.0, 20.0, 1.0, 20.0, 20.0, 20.0])
    )
    air = np.full(screw.CELLS, 20.0)
    around = flows.Around(along=air, air=20.0, base=20.0, sources=np.zeros(screw.CELLS))
    work = 0.0
    for second in range(60):
        centres = np.linspace(150.0, 250.0, 20) + second
        work += float(flows.advance(tight, now, np.full(20, 174.5), centres, around).sum()) * 174.5
    stored = tight.screw.bore_capacity * (now.bore - 20.0).sum() + tight.screw.outer_capacity * (now.outer - 20.0).sum()
    outer = [one.bracket_capacity * (one.to_bracket > 0.0) for one in (tight.anchor, tight.free)]
    outer.append(tight.nut.flange_capacity * (tight.nut.to_flange > 0.0))
    capacities = np.array([tight.nut.capacity, tight.anchor.capacity, tight.free.capacity, 0.0, *outer])
    bodies = capacities @ (now.bodies - 20.0)
    assert stored + bodies == pytest.approx(work, rel=1e-9)


def test_conduction_spreads_a_spot_like_the_endless_rod():
    """Heat E at one place: T = E / (rho c A sqrt(4 pi a t)) exp(-x^2 / 4 a t)"""
    steel = screw.steel(PAPER.screw, conduction=1.0)
    bore, outer = np.zeros(screw.CELLS), np.zeros(screw.CELLS)
    middle = screw.CELLS // 2
    bore[middle] = outer[middle] = 100.0
    for _ in range(6000):
        flows.spread(steel, bore, outer, np.zeros(screw.CELLS), 0.05)
    x = (screw.CELL_MM - screw.CELL_MM[middle]) * 1e-3
    spread = 4.0 * PAPER.screw.conductivity / PAPER.screw.volumetric_heat * 300.0
    exact = 100.0 * screw.CELL_M / math.sqrt(math.pi * spread) * np.exp(-(x**2) / spread)
    assert np.abs(screw.mean_temperature(bore, outer) - exact).max() < 2e-3 * exact.max()
    assert screw.mean_temperature(bore, outer).sum() == pytest.approx(100.0)


def test_halving_the_time_step_changes_nothing_that_matters(monkeypatch):
    coarse = simulate("FS-20", seconds=240.0)
    monkeypatch.setattr(heat, "MOVING_STEPS", 40)
    fine = simulate("FS-20", seconds=240.0)
    assert np.abs(coarse.truth.elongation_um - fine.truth.elongation_um).max() < 0.05
    assert np.abs(coarse.truth.channels - fine.truth.channels).max() < 0.03
