"""Whose machine a model is: by its own recordings, another's, and its own with a thermometer that fails."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.accuracy.compare import compare
from estimator.accuracy.machine import LIMIT_SD, Match, off_sd
from estimator.accuracy.review import review
from estimator.batch.trial import Trial
from estimator.model import Value
from estimator.work import Runs

KNOWN = {"nut_friction.power": 2.0, "nut_body.capacity": 30.0, "still_air.h": 0.3}  # sd, as a fit leaves them


@pytest.fixture(scope="module")
def known(small_model):
    """The small model as if it had been fitted: each parameter known to its sd."""
    return small_model.with_values({path: Value(small_model[path], sd) for path, sd in KNOWN.items()})


@pytest.fixture(scope="module")
def run_of(small, known, driven, live):
    """run_of(moved): a recording of a machine whose parameters are off by so many of these sd, in turn up and down."""
    drive = driven(small, 900, (20, 500), stroke=(0.0, 100.0))

    def lived(moved: float):
        signs = zip(KNOWN.items(), (1.0, -1.0, 1.0), strict=True)
        true = {path: known[path] + sign * moved * sd for (path, sd), sign in signs}
        return live(known.with_values(true), small, drive, seed=5, process=True).recording

    return lived


def off(model, rig, recording) -> float:
    trial = Trial(model, rig, recording)
    return off_sd(model, trial, trial.use)


def test_a_model_is_off_by_as_much_as_it_says_on_its_own_machine(run_of, small, known):
    assert 0.2 < off(known, small, run_of(0.0)) < 1.0
    assert 0.5 < off(known, small, run_of(1.5)) < 2.0


def test_on_another_machine_it_is_off_by_more(run_of, small, known):
    apart = off(known, small, run_of(12.0))
    assert apart > LIMIT_SD
    unsure = {path: Value(known[path], 12.0 * sd) for path, sd in KNOWN.items()}
    assert off(known.with_values(unsure), small, run_of(12.0)) < LIMIT_SD


def test_a_thermometer_that_fails_makes_no_other_machine(run_of, small, known):
    run = run_of(0.0)
    jumped, loose = run.channels.copy(), run.channels.copy()
    jumped[300:, 1] += 3.0
    loose[:, 1] = 22.0 + 0.4 * (loose[:, 1] - 22.0)
    for channels in (jumped, loose):
        assert off(known, small, replace(run, channels=channels)) < 1.2


def test_wrong_inputs_say_nothing_of_the_model(run_of, small, known):
    run = run_of(12.0)
    silent = np.where(run.time_s < 450, run.inputs["ambient"], np.nan)
    assert np.isnan(off(known, small, replace(run, inputs={**run.inputs, "ambient": silent})))


def test_review_and_compare_say_the_same_of_a_recording(run_of, small, known):
    run = run_of(12.0)
    found = compare(known, Runs(small, [run]))
    assert found.match.off_sd == [pytest.approx(review(run, small, known).off_sd, rel=1e-9)]
    assert found.match.own is False


def test_most_recordings_decide():
    nan, far = np.nan, LIMIT_SD + 0.1
    assert Match([far, far, 1.0]).own is False
    assert Match([far, nan, nan]).own is False
    assert Match([far, 1.0]).own is True
    assert Match([far, 1.0]).apart == [0]
    assert Match([nan]).own is None
    assert pytest.approx(1.9600, abs=1e-4) == LIMIT_SD
