"""The run that settles what is open: it is made, and the search asked again."""

from dataclasses import replace

import pytest

from ballscrew.report.search.next_run_words import next_run_sentence
from estimator.batch.trials import slow_trials_of
from estimator.effects import CATALOGUE
from estimator.hypotheses.candidates import candidates
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.hypothesis import refined
from estimator.missing_effect.suggest import suggest
from estimator.model import Prior
from estimator.next_run.foretold import REST_S
from estimator.next_run.next_run import best_of, next_run, panel_of
from estimator.next_run.plans import Plan, plans
from estimator.next_run.question import Question
from estimator.work import Runs
from tests.estimator.conftest import with_effect


@pytest.fixture
def made(bar, live, driven):
    """made(plan, truth): the run that a plan asks for, as the truth lives it."""

    def of(plan, truth):
        omega = plan.speed_m_min / 60 / (bar.screw.lead_mm * 1e-3) * 2 * 3.141592653589793
        seconds = REST_S + plan.drive_s + plan.stop_s
        run = driven(bar, seconds, (REST_S, REST_S + plan.drive_s), omega, plan.stroke_mm)
        return replace(live(truth, bar, run, seed=77).recording, name="next")

    return of


def test_a_run_that_decides_sets_rivals_apart_as_far_as_foretold(plain, bar, lives, made):
    """Churning against a nut that simply rubs more: a long drive tells, since churning fades."""
    truth = with_effect(plain, "churning", share=0.3)
    runs = Runs(bar, lives(truth)[:1])
    wide, found = candidates(plain, bar, [CATALOGUE["churning"]])
    trials, tried = slow_trials_of(wide, runs), plans(bar, runs.recordings)
    churning = refined(Ground(plain, ()), trials, found, {"churning.share": 0.3})
    rubbing = refined(Ground(plain, ("nut_friction.power",)), trials, [])
    two = Question("tie", (("churning", churning), ("nut_friction", rubbing)))
    run = best_of(tried, two, runs, trials)
    assert run.plan in tried
    assert run.separation_sd > 3

    def apart(some):
        again = (refined(h.ground, some, found if h is churning else []) for h in (churning, rubbing))
        costs = [panel.cost * panel.weight for panel in (panel_of(h, some) for h in again)]
        return costs[1] - costs[0]

    hottest = best_of([Plan("FS", 3600.0, 1200.0, (0.0, 100.0), 20.0, 174.5)], two, runs, trials)
    both = slow_trials_of(wide, Runs(bar, [*runs.recordings, made(run.plan, truth)]))
    assert (apart(both) - apart(trials)) ** 0.5 == pytest.approx(run.separation_sd, abs=1.5)  # the scatter of sensors
    assert hottest.separation_sd > 40
    assert run.plan.drive_s < 3600, "no run is asked for that heats the rig far more than those that were made"


def test_of_several_the_two_that_are_told_worst_count(plain, bar, lives):
    runs = Runs(bar, lives(with_effect(plain, "churning", share=0.3))[:1])
    wide, found = candidates(plain, bar, [CATALOGUE["churning"]])
    trials = slow_trials_of(wide, runs)
    churning = refined(Ground(plain, ()), trials, found, {"churning.share": 0.3})
    rubbing = refined(Ground(plain, ("nut_friction.power",)), trials, [])
    three = Question("tie", (("churning", churning), ("again", churning), ("nut_friction", rubbing)))
    least = best_of(plans(bar, runs.recordings)[:2], three, runs, trials)
    assert least.separation_sd < 0.2
    assert (least.between, least.several) == (("churning", "again"), True)


def test_a_parameter_is_known_afterwards_as_well_as_foretold(plain, bar, lives, made):
    truth = with_effect(plain, "churning", share=0.3)
    runs = Runs(bar, lives(truth)[:1])
    wide, found = candidates(plain, bar, [CATALOGUE["churning"]])
    trials, path = slow_trials_of(wide, runs), "churning.decay"
    h = refined(Ground(plain, ()), trials, found, {"churning.share": 0.3})
    run = best_of(plans(bar, runs.recordings), Question("badly known", (("churning", h),), path), runs, trials)
    both = slow_trials_of(wide, Runs(bar, [*runs.recordings, made(run.plan, truth)]))
    now = refined(h.ground, both, found, {"churning.share": 0.3})
    assert run.between == (path,)
    assert h.model[path] / run.separation_sd == pytest.approx(now.own()[path].sd, rel=0.3)
    assert now.own()[path].sd < 0.8 * h.own()[path].sd


@pytest.mark.study
def test_no_run_tells_radiation_from_still_air(plain, bar, lives, made):
    """That is foretold, and the run that would tell most tells nothing."""
    plain = plain.with_values({"still_air.h": replace(plain.values["still_air.h"], prior=Prior(8.0, 50.0))})
    truth = with_effect(plain, "radiation", emissivity=0.8)
    runs = lives(truth)
    found = suggest(plain, Runs(bar, runs), CATALOGUE.values())
    run = next_run(found, Runs(bar, runs))
    assert (run.why, set(run.between)) == ("tie", {"radiation", "still_air"})
    assert run.separation_sd < 1.0
    assert next_run_sentence(run, bar) == (
        f"No run of the patterns, speeds and levels seen would tell {run.between[0]} from {run.between[1]}."
    )
    assert suggest(plain, Runs(bar, [*runs, made(run.plan, truth)]), CATALOGUE.values()).verdict == "tie"


@pytest.mark.study
def test_what_is_not_proven_is_by_the_run_that_is_named(plain, bar, lives, made):
    """An expansion of 6 % more is worth having and four short recordings do not prove it."""
    truth = with_effect(plain, "expansion_error", error=0.06)
    runs = lives(truth)
    found = suggest(plain, Runs(bar, runs), CATALOGUE.values())
    run = next_run(found, Runs(bar, runs))
    assert (found.verdict, run.why, run.between[0]) == ("nothing_missing", "not proven", "expansion_error")
    assert run.separation_sd > 3
    again = suggest(plain, Runs(bar, [*runs, made(run.plan, truth)]), CATALOGUE.values())
    assert (again.verdict, again.found[0].names) == ("effect", ("expansion_error",))


def test_nothing_is_open_where_nothing_is_missing_or_an_effect_is_sure(searched):
    for runs, found in searched.values():
        assert next_run(found, runs) is None
