"""Heat on bodies that comes and goes within minutes is told, with both its times; where none does nothing is."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ballscrew
from estimator.batch.trials import unjudged
from estimator.effect import Effect, Param
from estimator.events.events import events
from estimator.terms import Heat
from estimator.work import Runs

FOLDER = Path(__file__).parents[3] / "examples" / "two_heaters"
OPENED_S, LASTS_S = ((600.0, 1200.0), 100.0)


class Lid(Effect):
    """A lid is opened once or twice."""

    power = Param(-0.5, "W", lo=-50.0, hi=50.0)
    lasts = Param(LASTS_S, "s", lo=0.0, hi=1e3)
    times = Param(2.0, "1", lo=1.0, hi=2.0)

    def terms(self, p, u, rig):
        at = zip(OPENED_S, (1.0, p.times - 1.0), strict=True)
        opened = sum(n * (u.motion.time_s >= at_s) * (u.motion.time_s < at_s + p.lasts) for at_s, n in at)
        yield Heat("body_1", p.power * opened)


@pytest.fixture(scope="module")
def two_heaters():
    """The rig, its model and a recording."""
    rig = ballscrew.load_rig(FOLDER)
    return rig, ballscrew.load_model(FOLDER / "model.toml"), ballscrew.read(FOLDER / "both.csv", rig)


def cooled_by(lid, rig, model, recording):
    """A recording in which a lid was opened."""
    alone, opened = (unjudged(m, rig, recording).pose(m).run.lagged for m in (model, lid))
    cooled = replace(recording, channels=recording.channels.copy())
    cooled.channels[1:] += opened - alone
    return cooled


def test_a_lid_that_is_opened_is_told_each_time(two_heaters):
    rig, model, recording = two_heaters
    found = events(model, Runs(rig, [cooled_by(model + Lid, rig, model, recording)]))
    assert [(event.kind, event.name) for event in found] == [("heat", "body_1")] * 2
    for event, at_s in zip(found, OPENED_S, strict=True):
        assert event.since_s == pytest.approx(at_s, abs=60.0)
        assert event.until_s == pytest.approx(at_s + LASTS_S, abs=60.0)
        assert event.heat_W == pytest.approx(-0.5, rel=0.3)
        assert "a lid or a door" in event.told()


def test_a_lid_that_is_opened_for_less_than_a_span_is_told_once(two_heaters):
    rig, model, recording = two_heaters
    lid = (model + Lid).with_values({"lid.power": -3.0, "lid.lasts": 20.0, "lid.times": 1.0})
    (event,) = events(model, Runs(rig, [cooled_by(lid, rig, model, recording)]))
    assert event.since_s == pytest.approx(600.0, abs=60.0)
    assert event.heat_W < 0.0


@pytest.mark.parametrize("last", [1, 421])
def test_a_thermometer_that_is_never_read_and_a_recording_of_which_one_row_is_tell_nothing(two_heaters, last):
    rig, model, recording = two_heaters
    silent = replace(recording, channels=recording.channels.copy())
    silent.channels[last:] = np.nan
    silent.channels[:, 1] = np.nan
    assert events(model, Runs(rig, [silent])) == []


def test_where_no_lid_is_opened_none_is_told(two_heaters):
    rig, model, recording = two_heaters
    assert events(model, Runs(rig, [recording])) == []


@pytest.mark.parametrize("begins_s", [700.0, 852.0, 1000.0])
def test_what_a_model_makes_wrong_of_a_heater_that_seldom_switches_is_no_lid(two_heaters, begins_s):
    """It lacks a lag; that shows in the one minute in which the heater is on, and nowhere else."""
    rig, model, recording = two_heaters
    time_s, dice = recording.time_s, np.random.default_rng(2)
    heater = np.where((time_s >= begins_s) & (time_s < begins_s + 60.0), 90.0, 0.0)
    pulsed = replace(recording, inputs={**recording.inputs, "heater_1": heater, "heater_2": 0.0 * heater})
    pulsed = replace(pulsed, channels=pulsed.channels.copy())
    pulsed.channels[1:] = unjudged(model, rig, pulsed).pose(model).run.lagged
    pulsed = replace(pulsed, channels=pulsed.channels + dice.normal(0.0, 0.05, pulsed.channels.shape))
    assert events(model.with_values({"sensor_lag.tau": 0.001}), Runs(rig, [pulsed])) == []
