"""An input that is wrong in all recordings is named with its size."""

from types import SimpleNamespace

import numpy as np
import pytest

from ballscrew.report.search.verdict import sentence
from ballscrew.search import Verdict
from estimator.batch.trials import unjudged
from estimator.effects import CATALOGUE
from estimator.hypotheses.candidates import at_null
from estimator.inputs.moved import moved
from estimator.inputs.start import SENSOR_K
from estimator.missing_effect import improve as improving
from estimator.missing_effect.suggest import suggest
from estimator.missing_effect.wrong_always import WRONG_INPUTS
from estimator.missing_effect.wrong_input import ALL, ZERO, corrected
from estimator.record import Recording
from estimator.rig import Rig
from estimator.sensitivity.sensitivity import nominal_columns
from estimator.sensitivity.tangent import tangent
from estimator.work import Runs

SHIFT_MM = 20.0
PATHS = [f"{effect.name}.{key}" for effect in WRONG_INPUTS for key in effect.params]
STEPS = {"shift": 1e-3, "error": 1e-5}


def shifted(runs: list[Recording], rig: Rig) -> list[Recording]:
    return [corrected(run, rig, ZERO, -SHIFT_MM) for run in runs]


def test_a_position_off_in_all_runs_is_named_with_its_size(plain, bar, lives):
    found = suggest(plain, Runs(bar, shifted(lives(plain)[:3], bar)), CATALOGUE.values())
    assert found.verdict == "input_error"
    assert (found.wrong_input.run, found.wrong_input.signal) == (ALL, "position")
    assert found.wrong_input.shift_mm == pytest.approx(SHIFT_MM, abs=4.0)
    said = sentence(Verdict(found, (), None, ()), bar)
    assert said.startswith("Nothing is missing but in all recordings, where position is +")


@pytest.mark.parametrize("off_K", [1.0, 4.0])
def test_the_air_may_be_wrong_in_all_runs_where_no_start_set_it_right(off_K, plain, bar, lives):
    runs = [corrected(run, bar, "ambient", -off_K) for run in lives(plain)[:2]]
    found = suggest(plain, Runs(bar, runs), CATALOGUE.values())
    if off_K < SENSOR_K:
        assert found.verdict == "nothing_missing"
    else:
        assert (found.verdict, found.wrong_input.run, found.wrong_input.signal) == ("input_error", ALL, "ambient")
        assert found.wrong_input.shift_K == pytest.approx(off_K, abs=0.5)


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("at", [0.0, 0.3])
def test_readings_move_with_an_error_as_differences_say(path, at, plain, bar, lives):
    """At its null too, where the inputs are as they stand."""
    model = plain
    for effect in WRONG_INPUTS:
        model = at_null(model + effect, effect)
    model, step = model.with_values({path: at}), STEPS[path.partition(".")[2]]
    trial = unjudged(model, bar, lives(plain)[0])
    ends = [trial.pose(model.with_values({path: at + h})).run.lagged for h in (-step, step)]
    posed = trial.pose(model)
    exact = next(nominal_columns(posed, [tangent(trial, posed, model, path)])).reading
    thermometers = bar.is_thermometer
    difference = (ends[1] - ends[0])[:, thermometers] / (2 * step)
    assert np.abs(difference).max() > 1e-4
    assert exact[:, thermometers] == pytest.approx(difference, abs=1e-4 * np.abs(difference).max())


def test_the_nut_covers_as_much_wherever_it_is(bar, driven):
    coverage = driven(bar, 60, (10, 50), stroke=(20.0, 80.0)).coverage
    there = moved(coverage, bar, shift_mm=20.0)
    assert there[:, :-2] == pytest.approx(coverage[:, 2:])  # two cells towards the end that the nut drives to
    assert moved(coverage, bar, share=0.9).sum(axis=1) == pytest.approx(coverage.sum(axis=1))


def test_improve_adds_nothing_that_may_be_a_wrong_input(plain, bar, lives, monkeypatch):
    tie = ("local_heat", WRONG_INPUTS[0].name)
    before = SimpleNamespace(refit=False)
    found = SimpleNamespace(verdict="tie", tie=tie, changed="", apart="", believed=(), before=before)
    monkeypatch.setattr(improving, "suggest", lambda *_, **__: found)
    done = improving.improve(plain, Runs(bar, lives(plain)[:1]), Runs(bar, []), [])
    assert [step.added for step in done.steps] == [""]
    assert done.last is found
