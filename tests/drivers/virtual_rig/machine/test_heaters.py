"""Planted heat: how it follows the table, and that it may begin within a run."""

import math
from functools import partial

import numpy as np
import pytest

from drivers.virtual_rig import simulate
from drivers.virtual_rig.machine.geometry import OMEGA_20
from drivers.virtual_rig.machine.heaters import LOCAL, Heaters, heaters
from drivers.virtual_rig.machine.planted import strengths
from drivers.virtual_rig.machine.screw import CELL_MM
from drivers.virtual_rig.population.constants import PAPER

DRIVING, STANDING = np.ones(20, dtype=bool), np.zeros(10, dtype=bool)


def planted(name: str) -> Heaters:
    return heaters(3, strengths({name: 1.0}, ()), PAPER.sources)


def driven(name: str, speed: float, since_start_s: float = 0.0) -> float:
    """W while driving at a share of 20 m/min."""
    return float(planted(name).heat(np.full(20, speed * OMEGA_20), DRIVING, 0.0, since_start_s).sum())


def rested(name: str, since_stop_s: float) -> float:
    """W at rest."""
    return float(planted(name).heat(np.zeros(10), STANDING, since_stop_s, 0.0).sum())


@pytest.mark.parametrize("name", LOCAL)
def test_heat_enters_around_its_place(name):
    source = planted(name)
    cells = source.local[name]
    assert cells.sum() == pytest.approx(LOCAL[name].watts)
    assert (cells @ CELL_MM) / cells.sum() == pytest.approx(source.places[name], abs=2.0)


def test_a_wiper_and_a_jet_follow_powers_of_the_speed():
    assert driven("rubbing_wiper", 0.25) == pytest.approx(6.0 / 8.0)
    assert driven("wide_jet", 0.25) == pytest.approx(-6.0 / 4.0)
    assert rested("rubbing_wiper", 100.0) == rested("wide_jet", 100.0) == 0.0


def test_a_surge_fades_from_the_start_of_a_drive_on():
    assert driven("start_surge", 0.5, 240.0) == pytest.approx(20.0 * math.exp(-2.0))
    assert rested("start_surge", 0.0) == 0.0


def test_a_blast_fades_and_a_soak_comes_after_a_stop():
    assert rested("slow_blast", 900.0) == pytest.approx(-6.0 / math.e)
    assert rested("slow_soak", 1200.0) == pytest.approx(3.0 * (1.0 - 1.0 / math.e))
    assert rested("slow_blast", -1.0) == rested("slow_soak", -1.0) == 0.0


@pytest.mark.parametrize("plant", [{"local_heat": -4.0}, {"nut_friction": 1.3}])
def test_what_is_planted_from_a_time_on_shows_from_there_on(plant):
    run = partial(simulate, "FS-5", cycles=1, seconds=300.0)
    healthy, later, always = run(), run(plant=plant, onset_s=150.0), run(plant=plant)
    apart = np.abs(later.truth.channels - healthy.truth.channels).max(axis=1)
    assert apart[:151].max() == 0.0
    assert apart[-1] > 0.1
    assert later.truth.time_s[151] == 151.0
    assert np.abs(later.truth.channels - always.truth.channels).max() > 0.1


def test_a_channel_may_go_wrong_within_a_run():
    run = partial(simulate, "FS-5", cycles=1, seconds=300.0)
    healthy, later = run(), run(plant={"channel_offset": 1.0}, onset_s=150.0)
    apart = np.abs(later.measured.channels - healthy.measured.channels).max(axis=1)
    assert apart[:150].max() == 0.0
    assert apart[150:].min() > 0.25
    assert later.onset_s == 150.0
