"""A run whose input is wrong is named, on recordings that a model has lived."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.trials import slow_trials_of
from estimator.effects import CATALOGUE
from estimator.hypotheses.criterion import GOOD
from estimator.hypotheses.ground import Ground, of_tables
from estimator.hypotheses.hypothesis import refined
from estimator.missing_effect.odd_run import odd_run
from estimator.missing_effect.side import Side
from estimator.missing_effect.suggest import suggest
from estimator.missing_effect.wrong_input import ZERO, _likely, corrected, gone, signals
from estimator.work import Runs

OF_SPEED = [CATALOGUE[name] for name in ("nut_speed_exponent", "churning")]  # what a wrong speed comes nearest to
OF_PLACE = [CATALOGUE[name] for name in ("local_heat_driving", "channel_offset")]


def test_a_wrong_label_names_run_and_signal(plain, bar, lives):
    runs, wrong = lives(plain)[:3], "speed and position"
    runs[1] = corrected(runs[1], bar, wrong, -np.log(1.2))
    found = suggest(plain, Runs(bar, runs), OF_SPEED)
    assert found.verdict == "input_error"
    assert (found.wrong_input.run, found.wrong_input.signal) == ("run 1", wrong)
    assert found.wrong_input.ratio == pytest.approx(1.2, abs=0.04)


def test_one_run_with_another_zero_of_the_position_is_named_with_its_size(plain, bar, lives):
    runs = lives(plain)[:3]
    runs[2] = corrected(runs[2], bar, ZERO, -30.0)
    found = suggest(plain, Runs(bar, runs), OF_PLACE)
    assert (found.verdict, found.wrong_input.run, found.wrong_input.signal) == ("input_error", "run 2", "position")
    assert found.wrong_input.shift_mm == pytest.approx(30.0, abs=5.0)


def test_no_run_is_odd_where_all_fit_alike(plain, bar, lives):
    runs = lives(plain)
    assert odd_run(Ground(plain, ()), slow_trials_of(plain, Runs(bar, runs))) is None


@pytest.mark.parametrize(("speed", "position"), [(1.0, 1.0), (1.2, 1.0), (1.0, 0.9), (1.2, 1.2)])
def test_how_far_the_table_goes_for_what_the_screw_turns(rig, driven, speed, position):
    run = driven(rig, 300, omega=43.6)
    label = replace(run, omega=speed * run.omega, inputs=run.inputs | {"position": position * run.inputs["position"]})
    assert gone(label, rig) == pytest.approx(position / speed, rel=0.01)
    unread = replace(run, inputs=run.inputs | {"position": np.full(len(run), np.nan)})
    assert np.isnan(gone(unread, rig))


@pytest.mark.parametrize(("signal", "share"), [("speed", 1.2), ("position", 1 / 1.2), ("speed and position", 1.0)])
def test_frames_tell_it_within_ticks_in_which_the_table_turns(rig, driven, signal, share):
    run = driven(rig, 300, omega=43.6)
    inputs = run.inputs | {"position": np.full(len(run), np.nan)}
    told = replace(run, inputs=inputs, pace=np.where(run.omega > 0, -1.0, np.nan))
    assert gone(corrected(told, rig, signal, np.log(1.2)), rig) == pytest.approx(share)


def test_a_speed_that_the_position_contradicts_is_wrong_alone(plain, bar, lives):
    (name, size), *_ = _likely(plain, bar, corrected(lives(plain)[1], bar, "speed", -np.log(1.2)))
    assert name == "speed"
    assert np.exp(size) == pytest.approx(1.2, abs=0.04)


def test_speed_that_the_position_bears_out_is_not_called_wrong_alone(plain, bar, lives):
    """The nut heats by half as much again, as at a higher speed."""
    run = lives(plain.with_values({"nut_friction.power": 1.5 * plain["nut_friction.power"]}))[2]
    likely = [name for name, _ in _likely(plain, bar, run)]
    assert "speed and position" in likely
    assert not {"speed", "position"} & {*likely}
    unread = replace(run, inputs=run.inputs | {"position": np.full(len(run), np.nan)})
    assert "speed" in [name for name, _ in _likely(plain, bar, unread)]


@pytest.mark.parametrize(("told_K", "may_be_wrong"), [(0.0, False), (3.0, True)])
def test_a_temperature_that_the_start_has_set_right_is_not_called_wrong(plain, bar, lives, told_K, may_be_wrong):
    """The nut heats by half as much again: an air colder by what a start no longer sets right would make less of it."""
    run = lives(plain.with_values({"nut_friction.power": 1.5 * plain["nut_friction.power"]}))[2]
    likely = [name for name, _ in _likely(plain, bar, corrected(run, bar, "ambient", -told_K))]
    assert ("ambient" in likely) == may_be_wrong


def test_a_law_of_other_exponents_is_no_wrong_speed(plain, bar, lives):
    """Of no one parameter more, and of no input, but of all that is held fixed."""
    off = {"nut_friction.n": 1.3, "still_air.h": 12.0}
    held = plain.with_values({path: replace(plain.values[path], fixed=True) for path in off})
    trials = slow_trials_of(held, Runs(bar, lives(plain.with_values(off))))
    side = Side(refined(of_tables(held), trials, []), trials, [])
    assert side.best.misfit > 1.3 * side.loosest.misfit
    assert side.loosest.misfit < GOOD
    assert side.loosest.model["nut_friction.n"] == pytest.approx(1.3, abs=0.03)


def test_a_body_of_the_model_is_no_input_of_its_name(full, rig):
    assert "nut" in rig.inputs
    assert {"ambient", "base", "speed"} <= set(signals(full, rig))
    assert "nut" not in signals(full, rig)
