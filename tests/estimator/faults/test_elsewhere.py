"""A position that is told with another zero is found by the thermometers, and no healthy one is accused for it."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.alarms.alarms import Alarms
from estimator.alarms.trust import Watch
from estimator.batch.replay import replay
from estimator.faults.fault import ELSEWHERE
from estimator.faults.sentences import sentences
from estimator.faults.use import Told, use_of
from estimator.filter import Filter
from estimator.inputs.moved import moved
from estimator.step import SERIES
from tests.conftest import stepped

SECONDS, SHIFT_MM = 420, 40.0


def shifted(run, rig, by_mm=SHIFT_MM):
    """The run with a position that is told with another zero from its first tick on."""
    position = run.inputs["position"] + by_mm
    coverage, stay = (moved(cover, rig, shift_mm=by_mm) for cover in (run.coverage, run.stay))
    return replace(run, inputs={**run.inputs, "position": position}, coverage=coverage, stay=stay)


@pytest.fixture(scope="module")
def run(strokes, paper):
    return shifted(strokes(SECONDS), paper[0])


@pytest.fixture(scope="module")
def track(run, paper):
    return replay(paper[1], paper[0], run)


def test_it_is_told_within_two_minutes_with_its_size_and_nobody_is_accused(track):
    told = np.flatnonzero(track.shift_mm)
    assert told[0] <= 120
    assert (track.shift_mm[told[0] :] != 0.0).all()
    assert abs(track.shift_mm[-1] - SHIFT_MM) < 15.0
    assert not track.fault.any()


@pytest.mark.parametrize("by_mm", [0.0, 3.0])
def test_a_position_that_is_right_is_not_named(by_mm, strokes, paper):
    assert not replay(paper[1], paper[0], shifted(strokes(SECONDS), paper[0], by_mm)).shift_mm.any()


def test_a_run_that_begins_in_a_rest_says_nothing_of_it_before_it_drives(strokes, paper):
    run = strokes(3000)
    rest = run.rows(slice(int(np.flatnonzero(run.omega)[-1]) + 30, None))  # its start is known badly: it cools fast
    assert not replay(paper[1], paper[0], rest).shift_mm.any()


def test_it_is_not_named_for_one_thermometer_that_drifts(strokes, paper):
    run = strokes(SECONDS)
    for i in (4, 6):  # beside the places where the nut turns round
        readings = run.channels.copy()
        readings[:, i] += 6.0 / 3600.0 * np.maximum(0.0, run.time_s - 60.0)
        assert not replay(paper[1], paper[0], replace(run, channels=readings)).shift_mm.any()


def test_live_judges_as_batch(run, track, paper):
    live = stepped(Filter(paper[1], paper[0]), run)
    for key in SERIES:
        np.testing.assert_allclose(getattr(live, key), getattr(track, key), rtol=1e-9, atol=1e-9, err_msg=key)


def test_the_estimate_is_not_to_be_trusted_and_an_alarm_says_why(run, track, paper):
    rig, names = paper[0], ("",) * len(paper[0].names)
    alarms, watch, begun = Alarms(rig), Watch(rig), []
    for k, sample in enumerate(run):
        step = track.step(k, names)
        begun += alarms.step(step)[0]
        watch.drive(step.time_s)
        watch.tick(sample, step, diverged=False)
        assert (ELSEWHERE in watch.trust(step.time_s).why) == (step.shift_mm != 0.0)
    (alarm,) = [alarm for alarm in begun if alarm.kind == "position"]
    assert alarm.since_s == track.time_s[np.flatnonzero(track.shift_mm)[0]]
    assert alarm.text.startswith(f"{ELSEWHERE}: as if it were off by +")


def test_review_says_since_when(run, track, paper):
    use = use_of(run, paper[0], Told.by(track))
    since_s = track.time_s[np.flatnonzero(track.shift_mm)[0]]
    (told,) = [line for line in sentences([use], paper[0]) if ELSEWHERE in line]
    assert f", at {since_s:.0f} s: " in told
