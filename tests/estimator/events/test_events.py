"""What begins within a run is told: when, where, how much; and where nothing begins nothing is."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.coarse import coarse
from estimator.batch.trials import Trials, unjudged
from estimator.effect import Effect, Param
from estimator.events.event import Event
from estimator.events.events import events, events_of, single
from estimator.events.onset import Step, likely
from estimator.events.readings import _pairs, share_lost
from estimator.events.signature import AsRead
from estimator.events.spans import spans
from estimator.rig import Signal
from estimator.terms import SCREW, Heat
from estimator.work import Runs
from tests.conftest import FAST

TICK_S, ONSET_S = 15, 2400.0


class Kindled(Effect):
    """A heater that somebody switches on, and may switch off again."""

    power = Param(3.0, "W", lo=-50.0, hi=50.0)
    until = Param(1e6, "s", fixed=True)

    def terms(self, p, u, rig):
        on = (u.motion.time_s > ONSET_S) & (u.motion.time_s < p.until)
        yield Heat(SCREW, p.power * on, over=rig.screw.overlap(50.0, 100.0) / 5)


@pytest.fixture(scope="module")
def runs(small, driven):
    """Two drives, each with a long rest, and the rig with their tick."""
    fast = replace(small, inputs={**small.inputs, "speed": Signal(unit="rpm")})
    parts = [coarse(driven(fast, 5010, (600, 1500 + 300 * i), FAST, (0.0, 100.0)), fast, TICK_S) for i in range(2)]
    return [run for run, _ in parts], parts[0][1]


@pytest.fixture(scope="module")
def told(runs, live, small_model):
    """Events of both runs, the second lived by a model with more."""

    def judge(model, change=lambda recording: recording):
        first, second = (
            live(m, runs[1], run, seed=i).recording
            for i, (m, run) in enumerate(zip((small_model, model), runs[0], strict=True))
        )
        pair = [replace(first, name="first"), change(replace(second, name="second"))]
        trials = Trials([unjudged(small_model, runs[1], each) for each in pair])
        return events_of(small_model, trials, Runs(runs[1], pair))

    return judge


def test_where_nothing_begins_nothing_is_told(told, small_model):
    assert told(small_model) == []


def test_a_heater_that_is_switched_on_is_told_with_time_and_place(told, small_model):
    (event,) = told(small_model + Kindled, lambda recording: replace(recording, began_s=1.7e9))
    assert event.began_s == 1.7e9
    assert (event.run, event.kind, event.until_s) == ("second", "heat", None)
    assert event.since_s == pytest.approx(ONSET_S, abs=300.0)
    assert event.from_mm < 75.0 < event.to_mm
    assert event.heat_W == pytest.approx(3.0, rel=0.4)
    assert "too little at" in event.told()


@pytest.mark.parametrize("lasts_s", [900.0, 1500.0])
def test_a_heater_that_is_switched_off_again_is_told_with_its_end(told, small_model, lasts_s):
    (event,) = told((small_model + Kindled).with_values({"kindled.until": ONSET_S + lasts_s, "kindled.power": 6.0}))
    assert event.since_s == pytest.approx(ONSET_S, abs=300.0)
    assert event.until_s == pytest.approx(ONSET_S + lasts_s, abs=300.0)
    assert event.heat_W == pytest.approx(6.0, rel=0.4)
    assert "and no more after that" in event.told()


def test_what_is_not_worth_having_is_not_told(told, small_model):
    """However surely it is there: sensors of no scatter show a hundredth of a watt."""
    few = (small_model + Kindled).with_values({"kindled.power": 0.02})
    assert told(few) == []


def test_what_cools_is_too_much_in_the_model(told, small_model):
    cooled = (small_model + Kindled).with_values({"kindled.power": -3.0})
    (event,) = told(cooled)
    assert event.heat_W < 0.0
    assert "too much at" in event.told()
    assert event.began_s is None


@pytest.mark.parametrize(
    ("gains", "span"),
    [([0, 80, 0, 0, 85, 70], 4), ([0, 90, 0, 0, 85, 70], 4), ([0, 90, 0, 0, 50, 70], 1), ([0, 0, 0, 0, 60, 90], 5)],
)
def test_what_acts_only_in_a_drive_begins_with_a_drive_rather_than_within_one(gains, span):
    step = Step("effect", None, None, np.zeros((1, 6)), np.array([True, True, False, False, True, True]))
    assert likely(np.array(gains, dtype=float), step) == span


def test_what_is_there_from_the_first_drive_on_has_not_begun(told, small_model):
    rubs = small_model.with_values({"nut_friction.power": 1.4 * small_model["nut_friction.power"]})
    assert told(rubs) == []


def test_a_thermometer_that_shifts_is_no_heat(told, small_model):
    def shift(recording):
        channels = recording.channels.copy()
        channels[recording.time_s > ONSET_S, 1] += 0.5
        return replace(recording, channels=channels)

    (event,) = told(small_model, shift)
    assert event.kind == "reading"
    assert event.channel is not None
    assert event.offset == pytest.approx(0.5, abs=0.1)
    assert event.since_s == pytest.approx(ONSET_S, abs=300.0)


@pytest.mark.parametrize(("by", "lost"), [(0.3, 0.3), (1.0, 1.0), (2.2, 0.0), (0.04, 0.0), (-0.3, 0.0)])
def test_a_loose_thermometer_shows_part_of_its_rise(small, runs, by, lost):
    """What falls as the screw warms is no contact."""
    time_s, off = np.arange(100.0) * TICK_S, np.zeros((100, 5))
    alone = np.tile(22.0 + 5.0 * np.sin(time_s / 300.0)[:, None], (1, 5))
    off[:, 1] = -by * (alone[:, 1] - 22.0)
    assert share_lost(AsRead(small, runs[0][0], time_s, off, alone), "T2", 0.0) == pytest.approx(lost)


def test_a_thermometer_that_comes_loose_follows_the_screw_less(told, small_model):
    def loosen(recording):
        channels = recording.channels.copy()
        channels[recording.time_s > 900.0, 1] -= 0.3 * (channels[recording.time_s > 900.0, 1] - 22.0)
        return replace(recording, channels=channels)

    (event,) = told(small_model, loosen)
    assert (event.kind, event.channel) == ("loose", "T2")
    assert event.share == pytest.approx(-0.3, abs=0.06)
    assert event.since_s == pytest.approx(900.0, abs=300.0)
    assert "as a thermometer that has come loose does" in event.told()


def test_two_plugs_that_are_exchanged_are_named_and_nothing_else(told, small_model):
    def exchange(recording):
        channels = recording.channels.copy()
        channels[:, [0, 2]] = channels[:, [2, 0]]
        return replace(recording, channels=channels)

    (event,) = told(small_model, exchange)
    assert (event.kind, event.channel, event.name) == ("exchanged", "T1", "T3")
    assert event.told().startswith("second: T1 and T3 show each other's temperature")


def test_two_that_look_exchanged_are_not_where_a_third_is_as_far_off():
    """Heat that the model has in the wrong place is too much at one end of it and too little at the other."""
    alone = np.tile([1.0, 4.0, 2.0, 5.0], (10, 1))
    off = np.tile([3.0, -3.0, 0.2, 0.1], (10, 1))
    assert list(_pairs(off, alone, np.arange(4))) == [(0, 1)]
    assert not list(_pairs(off + np.array([0.0, 0.0, 1.8, 0.0]), alone, np.arange(4)))


@pytest.mark.parametrize(("each", "grows"), [(0.08, True), (0.0, False)])
def test_friction_that_grows_from_recording_to_recording_is_named(runs, live, small_model, each, grows):
    lived = []
    for i in range(5):
        powers = [path for path in small_model.values if path.startswith("nut_friction.power")]
        worn = small_model.with_values({path: (1.0 + i * each) * small_model[path] for path in powers})
        recording = live(worn, runs[1], runs[0][i % 2], seed=i).recording
        lived.append(replace(recording, name=f"day {i}", began_s=1.7e9 + 86400.0 * i))
    trials = Trials([unjudged(small_model, runs[1], one) for one in lived[::-1]])
    found = [event for event in events_of(small_model, trials, Runs(runs[1], lived)) if event.kind == "growing"]
    assert [(event.run, event.name) for event in found] == ([("day 4", "nut_friction")] if grows else [])
    assert all(event.share == pytest.approx(4 * each, rel=0.3) for event in found)


def test_spans_are_cut_at_starts_and_stops_and_every_five_minutes(runs):
    run = runs[0][0]
    cut = spans(run)
    lasts = np.diff(np.append(cut.from_s, run.time_s[-1]))
    assert lasts.max() <= 300.0 + TICK_S
    turning = run.omega > 0
    assert all(len({*turning[cut.of_tick == span]}) == 1 for span in range(len(cut)))


def test_what_begins_in_most_recordings_is_the_models():
    """After every stop alike it is no event; once, or the other way round, it is."""
    often = [Event(run, 4000.0, 60.0, "heat", from_mm=300.0, to_mm=360.0, heat_W=2.0) for run in "abc"]
    once = Event("d", 900.0, 60.0, "heat_driving", from_mm=300.0, to_mm=360.0, heat_W=2.0)
    cools = Event("d", 2000.0, 60.0, "heat", from_mm=300.0, to_mm=360.0, heat_W=-2.0)
    assert single([*often, once, cools], 4) == [once, cools]
    assert single(often[:2], 4) == often[:2]
    places = [replace(cools, run=run, name=run, phase=(False, 280.0 + 20.0 * i)) for i, run in enumerate("abc")]
    assert single(places, 4) == []  # each another thing, and each as long after a stop
    driving = [*places[:2], replace(places[2], phase=(True, 320.0))]
    assert single(driving, 4) == driving
    assert single(often[:1], 1) == often[:1]


def test_the_clock_is_told_where_it_is_known():
    event = Event("CS-10.blf", 4310.0, 120.0, "heat", what="it heats")
    assert event.told() == "CS-10.blf: from 1 h 12 min after its start on (4310 s, +- 2 min) it heats."
    assert event.told("13:42") == "CS-10.blf: from 13:42 on (4310 s, +- 2 min) it heats."
    ended = replace(event, until_s=5000.0)
    assert (
        ended.told() == "CS-10.blf: from 1 h 12 min to 1 h 23 min after its start (4310 - 5000 s, +- 2 min) it heats."
    )
    assert ended.told("13:42", "13:53") == "CS-10.blf: from 13:42 to 13:53 (4310 - 5000 s, +- 2 min) it heats."


def test_runs_are_made_ready(runs, live, small_model):
    lived = [live(small_model, runs[1], run, seed=9).recording for run in runs[0]]
    assert events(small_model, Runs(runs[1], lived)) == []
