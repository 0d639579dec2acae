"""What is in no catalogue, and what recordings cannot tell from it."""

from dataclasses import replace

import pytest

from ballscrew.report.search.verdict import unknown_sentence
from estimator.batch.trials import slow_trials_of
from estimator.hypotheses.ground import as_given
from estimator.inputs.follower import SPEED, SPEED_ROOT, all_followers
from estimator.unknown.stand_ins import unknown_of
from estimator.unknown.unexplained import NEAR_MM, Unexplained, best_stand_in
from estimator.work import Runs
from tests.estimator.conftest import with_effect


def looked(plain, bar, runs) -> Unexplained:
    found = best_stand_in(as_given(plain, Runs(bar, runs)), slow_trials_of(plain, Runs(bar, runs)))
    assert found is not None
    return found


def rubbing(plain, bar, follower):
    return with_effect(plain, "unknown_heat", power=4.0, at=60.0, follows=all_followers(bar).index(follower))


def test_at_one_speed_the_drive_and_every_law_of_the_speed_are_rivals(plain, bar, lives):
    runs = lives(rubbing(plain, bar, SPEED))
    one_speed = looked(plain, bar, [runs[0], runs[3]])
    here = [unknown_of(rival.candidate, bar) for rival in one_speed.rivals]
    best = unknown_of(one_speed.candidate, bar)
    named = {best.follower.name, *(each.follower.name for each in here if each.at_mm == best.at_mm)}
    assert named >= {"drive", "speed", "speed2", "speed_root"}
    there = [r for r in one_speed.rivals if unknown_of(r.candidate, bar).at_mm == best.at_mm]
    laws = [r for r in there if unknown_of(r.candidate, bar).follower.name in ("speed2", "drive")]
    assert laws
    assert all(r.difference_se == 0 for r in laws)
    others = [each.at_mm for each in here if each.at_mm not in (None, best.at_mm)]
    assert all(abs(at - best.at_mm) >= NEAR_MM for at in others)
    assert "As well, by these recordings: " in unknown_sentence(one_speed, bar)
    many = replace(one_speed, rivals=(*one_speed.rivals, *one_speed.rivals))
    assert f", or {len(many.rivals) - 3} more." in unknown_sentence(many, bar)

    three_speeds = looked(plain, bar, runs)
    assert unknown_of(three_speeds.candidate, bar).follower == SPEED
    assert not {"drive", "speed2"} & {unknown_of(r.candidate, bar).follower.name for r in three_speeds.rivals}


def test_a_law_that_the_screen_has_not_is_asked_where_heat_was_found(plain, bar, lives):
    found = looked(plain, bar, lives(rubbing(plain, bar, SPEED_ROOT)))
    assert unknown_of(found.candidate, bar).follower == SPEED_ROOT
    assert found.candidate.at["unknown_heat.at"] == pytest.approx(60.0, abs=10.0)
    assert found.strength()["W"].value == pytest.approx(4.0, rel=0.1)
