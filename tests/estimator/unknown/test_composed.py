"""What no catalogue has becomes an effect with its exponent, time and width as they are."""

from dataclasses import replace

import numpy as np
import pytest

from ballscrew.report.search.composed_words import composed_json, composed_sentence
from estimator.batch.trials import slow_trials_of
from estimator.effect import Effect, Param
from estimator.effects.local import spot
from estimator.hypotheses.ground import as_given
from estimator.hypotheses.hypothesis import refined
from estimator.hypotheses.screening import Screened
from estimator.inputs.follower import all_followers
from estimator.terms import SCREW, Heat
from estimator.unknown import effect_text, law
from estimator.unknown.composed import Composed, _laws, composed
from estimator.unknown.unexplained import best_stand_in
from estimator.work import Runs


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


def looked(plain, bar, runs):
    """What a composition begins with: what stands in for it, what is left without, the recordings."""
    ground, trials = as_given(plain, Runs(bar, runs)), slow_trials_of(plain, Runs(bar, runs))
    found = best_stand_in(ground, trials)
    assert found is not None
    return found, refined(ground, trials, []).judged, trials


def made_of(plain, bar, runs) -> Composed | None:
    return composed(*looked(plain, bar, runs), taken=())


class AtTheEnd(Effect):
    """Something narrow rubs at the end of the screw."""

    power = Param(6.0, "W")

    def terms(self, p, u, rig):
        yield Heat(SCREW, p.power * u.speed_law(rig.the_screw(), 1.5), over=spot(rig, 0.0, 6.0))


def test_an_effect_may_end_where_the_screw_does(plain, bar, lives):
    made = made_of(plain, bar, lives(plain + AtTheEnd)[:2])
    assert made is not None
    own = {path.partition(".")[2]: value.value for path, value in made.hypothesis.own().items()}
    assert own["at"] == pytest.approx(0.0, abs=10.0)
    assert own["power"] == pytest.approx(6.0, rel=0.1)


@pytest.fixture(scope="module")
def rubbing(plain, bar, lives):
    return looked(plain, bar, lives(plain + Rubbing)[:3])


def test_no_exponent_hangs_on_how_well_it_is_known_beforehand(rubbing, monkeypatch):
    share = 0.7
    monkeypatch.setattr(law, "EXPONENT_SD", share * law.EXPONENT_SD)
    monkeypatch.setattr(effect_text, "WIDTH_SD_MM", share * effect_text.WIDTH_SD_MM)
    made = composed(*rubbing, taken=())
    assert made is not None
    assert made.hypothesis.model[f"{made.effect.name}.n"] == pytest.approx(1.5, abs=0.1)


def test_a_place_a_width_and_an_exponent_are_found(rubbing):
    made = composed(*rubbing, taken=["heat_near70"])
    assert made is not None
    assert made.effect.name == "heat_near70_no2"
    own = {path.partition(".")[2]: value for path, value in made.hypothesis.own().items()}
    for key, truth in (("power", 6.0), ("at", 70.0), ("n", 1.5)):
        assert own[key].value == pytest.approx(truth, abs=3 * own[key].sd), key
    assert own["n"].sd < 0.1
    assert own["width"].value == pytest.approx(60.0, abs=own["width"].sd)
    assert own["width"].sd < 35.0
    assert made.hypothesis.misfit < 0.1 * made.before.misfit
    assert made.effect.params["n"].value == pytest.approx(own["n"].value, rel=1e-5)
    said = composed_sentence(made)
    assert "in step with a power of the speed; q = P |omega / omega_ref|^n" in said
    assert "something that rubs" in said
    told = composed_json(made, None, None, None)
    assert told["from_mm"] < 70.0 < told["to_mm"]
    assert told["after"]["temperature_K"] < told["before"]["temperature_K"]


def test_a_time_is_found_and_heat_taken_away_cools(plain, bar, lives):
    made = made_of(plain, bar, lives(plain + Blast)[:3])
    assert made is not None
    own = {path.partition(".")[2]: value for path, value in made.hypothesis.own().items()}
    assert own["tau"].value == pytest.approx(120.0, rel=0.2)
    assert own["power"].value == pytest.approx(-6.0, rel=0.2)
    assert made.unknown.at_mm == pytest.approx(120.0, abs=5.0)
    assert (
        made.effect.sentence() == f"Something cools the screw around {made.unknown.at_mm:.0f} mm, after a stop, fading."
    )
    assert "air or coolant that reaches it at rest" in composed_sentence(made)


def test_nothing_is_composed_of_one_recording(rubbing):
    found, before, trials = rubbing
    assert composed(found, before, [trials[0]], taken=()) is None


def test_what_would_conduct_the_wrong_way_is_not_composed(rubbing, bar):
    """Heat that grows with the temperature there: no effect of a user's own may be so."""
    found, _, _ = rubbing
    follows = [follower.name for follower in all_followers(bar)].index("temperature")
    at = {**found.candidate.at, "unknown_heat.follows": float(follows)}
    losses = [
        Screened(replace(found.candidate, at=at), found.judged, {found.candidate.paths[0]: power})
        for power in (-0.15, 0.15)
    ]
    laws = [{one.follower.name for one, _ in _laws(replace(found, there=(loss,)), bar)} for loss in losses]
    assert ["temperature" in each for each in laws] == [False, True]
