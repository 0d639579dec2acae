"""Effects added one at a time, on recordings that a model with two more has lived."""

import pytest

from estimator.batch.trials import slow_trials_of
from estimator.effects import CATALOGUE
from estimator.hypotheses.candidates import candidates
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.hypothesis import refined
from estimator.hypotheses.screening import screening
from estimator.missing_effect.improve import improve
from estimator.missing_effect.suggest import suggest
from estimator.work import Runs
from tests.estimator.conftest import Chips, with_effect


def test_improve_adds_both_of_two(plain, bar, lives):
    truth = with_effect(with_effect(plain, "churning", share=0.5), "local_heat", power=2.0, at=150.0)
    runs = lives(truth)
    found = improve(plain, Runs(bar, runs[:3]), Runs(bar, runs[3:]), list(CATALOGUE.values()))
    assert {step.added for step in found.steps} >= {"churning", "local_heat"}
    errors = [step.held_out.temperature_K for step in found.steps]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.1 * errors[0]
    assert found.last.verdict == "nothing_missing"


def test_a_step_that_foretells_what_is_held_out_worse_is_not_kept(plain, bar, lives):
    """What is held out has none of it: the machine was mended."""
    runs, mended = lives(with_effect(plain, "churning", share=0.5)), lives(plain)
    found = improve(plain, Runs(bar, runs[:3]), Runs(bar, mended[3:]), list(CATALOGUE.values()))
    assert [(step.added, step.kept) for step in found.steps][:2] == [("", True), ("churning", False)]
    assert found.model.effects == plain.effects
    assert len(found.steps) == 2


def test_what_an_earlier_step_added_moves_with_the_next(plain, bar, lives):
    """Churning alone took on a part of the local heat: its value is right again once both are there."""
    truth = with_effect(with_effect(plain, "churning", share=0.5), "local_heat", power=2.0, at=150.0)
    bent = with_effect(plain, "churning", share=0.6)
    wide, seats = candidates(bent, bar, [CATALOGUE["local_heat"]])
    runs = Runs(bar, lives(truth)[:2])
    trials = slow_trials_of(wide, runs)
    held, moved = (screening(Ground(bent, paths), wide, seats, trials) for paths in ((), ("churning.share",)))
    best = moved.best()[0]
    assert best.judged.misfit < 0.5 * held.best()[0].judged.misfit
    assert best.first["churning.share"] == pytest.approx(0.5, abs=0.03)
    found = suggest(bent, runs, [CATALOGUE["local_heat"]], loose=["churning"])
    assert found.as_given.paths == ("churning.share", "churning.decay", "churning.recovery")
    assert found.as_given.misfit < refined(Ground(bent, ()), trials, []).misfit


@pytest.mark.study
def test_a_run_within_which_something_began_is_left_out(plain, bar, lives):
    """All steps are judged by the others, so that leaving it out is not what makes the model look better."""
    truth = with_effect(plain, "churning", share=0.5)
    runs = lives(truth)
    runs[1] = lives(truth + Chips)[1]
    found = improve(plain, Runs(bar, runs), Runs(bar, []), list(CATALOGUE.values()))
    (apart,) = found.apart
    assert (apart.apart, apart.verdict, apart.by_others) == ("run 1", "effect", "effect")
    assert [event.run for event in apart.events] == ["run 1"]
    assert [step.added for step in found.steps][:2] == ["", "churning"]
    others = Runs(bar, [run for run in runs if run.name != "run 1"])
    alone = refined(Ground(plain, ()), slow_trials_of(plain, others), [])
    assert found.steps[0].cross_validated == alone.judged.error
