"""Position against speed: what a drive cannot do is said within a few ticks, what it does never."""

from __future__ import annotations

import numpy as np
import pytest

from estimator.faults.travel import Travel


def told(rig, position, omega) -> list[str]:
    travel, whys = Travel(rig), []
    for each in zip(position, omega, strict=True):
        travel.step(*each)
        whys.append(travel.why)
    return whys


@pytest.fixture
def drive(rig):
    """Rest, strokes to and fro between 0 and 300 mm at 50 mm/s, rest: position and speed at each second."""
    time = np.arange(200.0)
    way = 50.0 * np.clip(time - 20.0, 0.0, 120.0)
    position = 300.0 - np.abs(300.0 - way % 600.0)
    speed = np.where((time > 20) & (time <= 140), 50.0, 0.0)
    return position, speed / (rig.the_screw().lead_mm / (2 * np.pi))


def test_strokes_and_gaps_are_right(rig, drive):
    position, omega = drive
    assert set(told(rig, position, omega)) == {""}
    position[50:60], omega[80:90] = np.nan, np.nan
    assert set(told(rig, position, omega)) == {""}


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_of_the_tick_in_which_a_drive_begins_or_ends_the_speed_need_not_be_right(share, rig, drive):
    """On a bus sixty times as fast as the rig the frames of a tick have no time of their own."""
    position, omega = drive
    omega[[21, 140]] *= share
    assert set(told(rig, position, omega)) == {""}


@pytest.mark.parametrize("at", [10, 70, 170])
def test_a_shift_is_said_until_it_is_back(at, rig, drive):
    position, omega = drive
    position[at : at + 20] += 40.0
    whys = told(rig, position, omega)
    assert all(why.startswith("the position jumped by ") for why in whys[at : at + 20])
    assert set(whys[:at] + whys[at + 20 :]) == {""}


def test_a_position_that_stands_and_a_speed_that_is_dead(rig, drive):
    position, omega = drive
    stuck = np.where(np.arange(200) >= 60, position[60], position)
    assert told(rig, stuck, omega)[64] == "the position stands still though the speed says that the screw turns"
    assert told(rig, position, 0.0 * omega)[24] == "the position moves further than the speed says"
    running = np.where(np.arange(200) >= 100, omega[100], omega)
    assert told(rig, position, running)[145] == "the position stands still though the speed says that the screw turns"
