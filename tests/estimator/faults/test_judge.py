"""One bad thermometer never becomes an estimate: each failure by its name, live as after the fact; no healthy one."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from drivers.recordings import read_recording
from drivers.virtual_rig import simulate, write
from estimator.batch.replay import replay
from estimator.batch.trial import Trial
from estimator.faults import recovery
from estimator.faults.fault import Fault
from estimator.faults.judge import START_S
from estimator.filter import Filter
from tests.conftest import stepped

SECONDS, AT, ONE, OTHER = 1300, 500, 5, 12


@pytest.fixture(scope="module")
def lived(rig, full, driven, live):
    """A drive of five minutes and a quarter of an hour of rest, process noise and unknown zeros included."""
    return live(full, rig, driven(rig, SECONDS, (20, 320)), seed=2, process=True)


@pytest.fixture(scope="module")
def without(lived, rig, full):
    """The same without thermometer ONE from AT on."""
    return replay(full, rig, lived.recording, lambda t: (np.arange(len(rig.names)) == ONE) & (t > AT))


@pytest.fixture(scope="module")
def tick_by_tick(lived, rig, full):
    """tick_by_tick(log): as live takes them; the ticks before AT, in which no log differs, were taken once."""
    before = Filter(full, rig)
    steps = [before.step(sample) for sample in lived.recording.rows(slice(AT))]

    def of(log):
        own = copy.deepcopy(before, {id(each): each for each in (rig, full)})
        return stepped(own, log.rows(slice(AT, None)), steps)

    return of


def changed(lived, change):
    """The recording with thermometer ONE as `change` makes it of its readings and the seconds since, from AT on."""
    readings = lived.recording.channels.copy()
    readings[AT:, ONE] = change(readings[AT:, ONE], np.arange(SECONDS - AT))
    return replace(lived.recording, channels=readings)


def noise(since):
    return np.random.default_rng(0).uniform(-30.0, 30.0, len(since))


FAILURES = {
    "+0.25 K": (lambda y, s: y + 0.25, Fault.JUMPED, 10, 0.02),
    "-20 K": (lambda y, s: y - 20.0, Fault.JUMPED, 10, 0.02),
    "85 degC": (lambda y, s: 0 * y + 85.0, Fault.STUCK, 20, 0.02),
    "stuck": (lambda y, s: 0 * y + y[0], Fault.STUCK, 20, 0.05),
    "loose": (lambda y, s: y + np.where(s % 40 < 12, noise(s), 0.0), Fault.LOOSE, 60, 0.05),
    "spikes": (lambda y, s: y + np.where(s % 23 == 5, 6.0, 0.0), Fault.LOOSE, 60, 0.05),
}


@pytest.mark.parametrize("name", FAILURES)
def test_a_failure_is_named_left_out_and_adds_nothing(name, lived, without, rig, full):
    change, fault, within_s, um = FAILURES[name]
    log = changed(lived, change)
    track = replay(full, rig, log)
    named = np.flatnonzero(track.fault[:, ONE] == fault)
    assert named[0] - AT <= within_s
    assert abs(track.elongation_um - without.elongation_um)[AT:].max() < um
    assert not (np.delete(track.fault, ONE, axis=1) > Fault.JUDGED).any()
    assert (track.fault[:AT] == Fault.NONE).all()


def test_live_and_a_trial_name_it_as_well(lived, tick_by_tick, rig, full):
    """Others: batch/test_replayed_faults.py and, of drifts, test_suspicion.py."""
    change, _, within_s, _ = FAILURES["spikes"]
    log = changed(lived, change)
    track, shown = replay(full, rig, log), slice(AT + within_s + 30)
    live = tick_by_tick(log.rows(shown))
    np.testing.assert_array_equal(live.fault, track.fault[shown])
    np.testing.assert_allclose(live.elongation_um, track.elongation_um[shown], rtol=0, atol=1e-9)
    trial = Trial(full, rig, log)
    np.testing.assert_array_equal(trial.fault, track.fault[1:])
    assert trial.muted[track.fault[1:] > Fault.NONE].all()


def test_nothing_is_said_of_healthy_thermometers(lived, rig, full):
    assert not replay(full, rig, lived.recording).fault.any()


def test_a_run_begins_again_in_its_first_minute_only(rig, full, driven):
    """A lone thermometer that reads whole kelvins, warmed by what the model does not foretell."""
    alone, model = replace(rig, channels={"T07": rig.channels["T07"]}), full - "displacement"
    idle = driven(alone, 400, (10**8, 10**9))
    recording = replace(idle, channels=22.0 + np.round(0.05 * idle.time_s)[:, None])
    last = Trial(model, alone, recording).begun[-1]
    assert last < 30.0 + START_S
    one = Filter(model, alone)
    stepped(one, recording)
    assert one.run.sample.time_s == recording.time_s[last]


def test_wrong_readings_of_all_are_no_loose_contacts(lived, rig, full):
    readings = lived.recording.channels.copy()
    for k in (50, 70, 90):
        readings[AT + k, rig.is_thermometer] += 6.0
    track = replay(full, rig, replace(lived.recording, channels=readings))
    assert not track.fused[AT + 50, rig.is_thermometer].any()
    assert not (track.fault > Fault.JUDGED).any()
    assert track.fused[AT + 92 :, rig.is_thermometer].all()


@pytest.mark.parametrize(("again_s", "left_out_s"), [(300, 120), (700, 60)])
def test_what_has_been_well_for_long_is_forgiven(again_s, left_out_s, lived, rig, full, monkeypatch):
    """A minute is doubled for what fails again soon, and is a minute again for what was well ten times as long."""
    monkeypatch.setattr(recovery, "FORGIVEN", 5.0)
    track = replay(
        full, rig, changed(lived, lambda y, s: y + np.where(np.isin(s, (1, 5, again_s - 9, again_s)), 6.0, 0.0))
    )
    assert np.count_nonzero(track.fault[AT + again_s :, ONE]) == pytest.approx(left_out_s, abs=2)


def test_two_that_are_swapped_do_not_hide_each_other(lived, rig, full):
    readings = lived.recording.channels.copy()
    readings[AT:, [ONE, OTHER]] = readings[AT:, [OTHER, ONE]]
    track = replay(full, rig, replace(lived.recording, channels=readings))
    assert (track.fault[AT + 300 :, [ONE, OTHER]] > Fault.JUDGED).all()
    assert not (np.delete(track.fault, [ONE, OTHER], axis=1) > Fault.JUDGED).any()


def test_one_that_jumps_back_is_taken_back_after_a_minute_and_after_two(lived, rig, full):
    log = changed(lived, lambda y, s: y + np.where((s < 50) | ((s > 200) & (s < 250)), 2.0, 0.0))
    fused = replay(full, rig, log).fused[AT:, ONE]
    left = np.flatnonzero(~fused)
    assert left[0] == 0
    assert np.flatnonzero(np.diff(left) > 1).size == 1
    first, second = np.split(left, np.flatnonzero(np.diff(left) > 1) + 1)
    assert first[-1] == pytest.approx(50 + 60, abs=2)
    assert (second[0], second[-1]) == (201, pytest.approx(250 + 120, abs=2))


def test_one_that_the_model_comes_near_to_is_not_taken_back(lived, rig, full):
    """It stands 0.3 K off while the screw cools down by more than that."""
    log = changed(lived, lambda y, s: 0 * y + y[:5].mean() + np.where(s < 5, 0.0, 0.3) + 0.02 * noise(s) / 30)
    assert (replay(full, rig, log).fault[AT + 40 :, ONE] > Fault.JUDGED).all()


def test_a_board_that_shifts_all_by_a_kelvin_gives_them_other_zeros(lived, rig, full):
    readings = lived.recording.channels.copy()
    readings[AT:, rig.is_thermometer] += 1.0
    track = replay(full, rig, replace(lived.recording, channels=readings))
    healthy = replay(full, rig, lived.recording)
    assert abs(track.elongation_um - healthy.elongation_um).max() < 0.3
    jumped = np.flatnonzero(track.jump[:, ONE])
    assert (len(jumped), jumped[0] - AT) == (1, pytest.approx(4, abs=1))
    assert track.jump[jumped[0], ONE] == pytest.approx(1.0, abs=0.15)


def test_a_displacement_that_jumps_has_another_zero(lived, rig, full):
    readings = lived.recording.channels.copy()
    readings[AT:, ~rig.is_thermometer] += 20.0
    track = replay(full, rig, replace(lived.recording, channels=readings))
    healthy = replay(full, rig, lived.recording)
    assert abs(track.elongation_um - healthy.elongation_um).max() < 0.3
    assert track.fused[AT + 20 :, -1].any()


TURN_S, TURNS = 400, "T04"


@pytest.fixture(scope="module")
def shuttling(paper, tmp_path_factory):
    """Fifteen minutes of full strokes on the machine of the recordings: the nut turns round beside T04."""
    log = write(simulate("FS-5", seed=101, seconds=900), tmp_path_factory.mktemp("rig") / "a.log")
    return read_recording(log, paper[0])


def test_a_slow_drift_where_the_nut_turns_round_is_found_within_minutes(shuttling, rig, shipped):
    """There a model that is wrong makes what a drift makes: what its parameters leave in doubt tells them apart."""
    readings, i = shuttling.channels.copy(), rig.index(TURNS)
    readings[TURN_S:, i] += 3.0 / 3600 * np.arange(len(readings) - TURN_S)
    track = replay(shipped, rig, replace(shuttling, channels=readings))
    without = replay(
        shipped, rig, shuttling, lambda t: (np.arange(len(rig.names)) == i) & (t >= shuttling.time_s[TURN_S])
    )
    suspected = np.flatnonzero(track.may_drift_K[:, i])
    assert suspected[0] - TURN_S <= 180
    assert abs(track.elongation_um - without.elongation_um)[TURN_S:].max() < 0.2
    assert not np.delete(track.fault, i, axis=1).any()


def test_no_thermometer_of_a_machine_is_accused_under_a_model_that_is_wrong(shuttling, rig, shipped):
    """The nut heats the screw by a fifth more than the model says, the air cools it by a fifth less."""
    wrong = {"nut_friction.power": 0.8, "rotating_convection.h": 1.25, "nut_body.g": 0.8}
    off = shipped.with_values({path: shipped[path] * factor for path, factor in wrong.items()})
    for each in (shipped, off):
        assert not (replay(each, rig, shuttling).fault > Fault.JUDGED).any()
