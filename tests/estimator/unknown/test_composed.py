"""What no catalogue has becomes an effect with its exponent, time and width as they are."""

from __future__ import annotations

import numpy as np
import pytest

from ballscrew.report.search.composed_words import composed_json, composed_sentence
from estimator.batch.trials import slow_trials_of
from estimator.effect import Effect, Param
from estimator.effects.local import spot
from estimator.hypotheses.ground import as_given
from estimator.hypotheses.hypothesis import refined
from estimator.inputs.follower import all_followers
from estimator.terms import SCREW, Heat
from estimator.unknown.composed import Composed, composed
from estimator.unknown.unexplained import best_stand_in
from estimator.work import Runs
from tests.estimator.conftest import with_effect


class Rubbing(Effect):
    """Something wide rubs, with a law that no follower has."""

    power = Param(6.0, "W")
    at = Param(70.0, "mm")
    width = Param(60.0, "mm")
    n = Param(1.5, "1")

    def terms(self, p, u, rig):
        yield Heat(SCREW, p.power * u.speed_law(rig.the_screw(), p.n), over=spot(rig, p.at, p.width))


class Blast(Effect):
    """A blast of cold air after each stop, of a time that no follower has."""

    power = Param(-6.0, "W")
    tau = Param(120.0, "s")

    def terms(self, p, u, rig):
        after = (1.0 - u.motion.turning) * u.motion.moved * np.exp(-u.motion.since_s / p.tau)
        yield Heat(SCREW, p.power * after, over=spot(rig, 120.0, 30.0))


def made_of(plain, bar, runs, taken=()) -> Composed | None:
    ground, trials = as_given(plain, Runs(bar, runs)), slow_trials_of(plain, Runs(bar, runs))
    found = best_stand_in(ground, trials)
    assert found is not None
    return composed(found, refined(ground, trials, []).judged, trials, taken)


def test_a_place_a_width_and_an_exponent_are_found(plain, bar, lives):
    made = made_of(plain, bar, lives(plain + Rubbing), taken=["heat_near70"])
    assert made is not None
    own = {path.partition(".")[2]: value for path, value in made.hypothesis.own().items()}
    for key, truth in (("power", 6.0), ("at", 70.0), ("n", 1.5)):
        assert own[key].value == pytest.approx(truth, abs=3 * own[key].sd), key
    assert own["n"].sd < 0.1
    assert own["width"].value == pytest.approx(60.0, abs=20.0)
    assert made.hypothesis.misfit < 0.1 * made.before.misfit
    assert made.effect.params["n"].value == pytest.approx(own["n"].value, rel=1e-5)
    said = composed_sentence(made)
    assert "in step with a power of the speed; q = P |omega / omega_ref|^n" in said
    assert "something that rubs" in said
    told = composed_json(made, None, None, None)
    assert told["from_mm"] < 70.0 < told["to_mm"]
    assert told["after"]["temperature_K"] < told["before"]["temperature_K"]


def test_a_time_is_found_and_heat_taken_away_cools(plain, bar, lives):
    made = made_of(plain, bar, lives(plain + Blast))
    assert made is not None
    own = {path.partition(".")[2]: value for path, value in made.hypothesis.own().items()}
    assert own["tau"].value == pytest.approx(120.0, rel=0.2)
    assert own["power"].value == pytest.approx(-6.0, rel=0.2)
    assert made.unknown.at_mm == pytest.approx(120.0, abs=5.0)
    assert (
        made.effect.sentence() == f"Something cools the screw around {made.unknown.at_mm:.0f} mm, after a stop, fading."
    )
    assert "air or coolant that reaches it at rest" in composed_sentence(made)


def test_nothing_is_composed_of_one_recording(plain, bar, lives):
    assert made_of(plain, bar, lives(plain + Rubbing)[:1]) is None


def test_what_would_conduct_the_wrong_way_is_not_composed(plain, bar, lives):
    """Heat that grows with the temperature there: no effect of a user's own may be so."""
    follows = [follower.name for follower in all_followers(bar)].index("temperature")
    runs = lives(with_effect(plain, "unknown_heat", power=-0.15, at=60.0, follows=follows))
    made = made_of(plain, bar, runs)
    assert made is None or "g" not in made.effect.params
