"""The growth at last against the simulation of a drive that lasts for hours."""

from dataclasses import replace

import pytest

from drivers.virtual_rig import simulate
from drivers.virtual_rig.population.constants import PAPER
from drivers.virtual_rig.population.draw import REACHED_UM, SLOWEST, machine
from drivers.virtual_rig.population.steady import steady_growth_um


def test_growth_at_last_is_the_simulation_s():
    run = simulate("FS-2.5", plant={"nut_friction": 0.4}, cycles=1, max_drive_s=6000.0, stop_s=1.0)
    weak = replace(PAPER, nut=replace(PAPER.nut, drag_torque=0.4 * PAPER.nut.drag_torque))
    assert run.travel.drives[0].stop_s > 6000.0
    assert steady_growth_um(weak, SLOWEST) == pytest.approx(run.truth.elongation_um.max(), rel=0.2)


def test_every_machine_can_follow_the_protocol():
    assert all(steady_growth_um(machine(number), SLOWEST) > REACHED_UM for number in range(41))
