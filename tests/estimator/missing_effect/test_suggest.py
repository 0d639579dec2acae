"""Finding what is missing, on recordings that a model with one effect more has lived."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.trials import Trials, slow_trials_of, unjudged
from estimator.effect import Effect, Param
from estimator.effects import CATALOGUE
from estimator.faults.fault import Fault, Spell
from estimator.hypotheses.criterion import GOOD
from estimator.hypotheses.ground import as_given
from estimator.inputs.follower import DRIVE, LOSS_DRIVE, REST, TEMPERATURE, followers
from estimator.missing_effect import suggest as search_
from estimator.missing_effect.improve import improve
from estimator.missing_effect.suggest import suggest
from estimator.missing_effect.suggestion import Suggestion
from estimator.missing_effect.wrong_always import inputs_in
from estimator.model import Model, Prior
from estimator.record import Recording
from estimator.rig import Rig
from estimator.terms import SCREW, Link, Store
from estimator.unknown.stand_ins import unknown_of
from estimator.work import Runs
from tests.conftest import FAST
from tests.estimator.conftest import with_effect


def search(plain: Model, bar: Rig, runs: Sequence[Recording]) -> Suggestion:
    return suggest(plain, Runs(bar, runs), CATALOGUE.values())


def test_the_planted_effect_is_the_verdict(searched):
    _, found = searched["channel_offset"]
    assert (found.verdict, found.found[0].names) == ("effect", ("channel_offset",))
    assert found.found[0].model["channel_offset.offset"] == pytest.approx(0.4, rel=0.3)


def test_what_explains_too_little_is_not_what_is_missing_while_the_model_stays_far_off(searched, monkeypatch):
    """By readings that are taken for exact, of an effect of which more is asked than it does."""
    runs, found = searched["channel_offset"]
    assert not found.partly
    monkeypatch.setattr(search_, "FAR", 0.1)
    monkeypatch.setattr(search_, "most", lambda before, after: after.misfit < 1e-3 * before.misfit)
    partly = search(found.as_given.ground.model, runs.rig, runs.recordings)
    assert (partly.verdict, partly.partly) == ("nothing_in_catalogue", "channel_offset")
    assert partly.found[0].names == ("channel_offset",)


@pytest.mark.study
def test_what_leaves_little_takes_more_recordings(plain, bar, lives):
    """An expansion of 6 % more leaves no more than a good model does: four short recordings do not prove it."""
    truth = with_effect(plain, "expansion_error", error=0.06)
    few, more = lives(truth), lives(truth, seed=20)
    assert search(plain, bar, few).verdict == "nothing_missing"
    found = search(plain, bar, [*few, *(replace(run, name=f"{run.name} again") for run in more)])
    assert (found.verdict, found.found[0].names) == ("effect", ("expansion_error",))
    assert found.found[0].model["expansion_error.error"] == pytest.approx(0.06, rel=0.3)


def test_healthy_recordings_say_what_has_changed_since(plain, bar, lives):
    """The model's nut is another one's; the healthy runs tell, so that churning does not bend it."""
    other = plain.with_values({"nut_friction.power": 26.0})
    new, healthy = lives(with_effect(plain, "churning", share=0.5))[:2], lives(plain, seed=40)[:1]
    found = suggest(other, Runs(bar, new), CATALOGUE.values(), healthy=Runs(bar, healthy))
    assert (found.verdict, found.found[0].names) == ("effect", ("churning",))
    assert not found.before.refit
    assert found.as_given.ground.model["nut_friction.power"] == pytest.approx(20.0, rel=0.02)
    assert found.found[0].model["churning.share"] == pytest.approx(0.5, rel=0.2)


def test_a_parameter_of_another_value_is_no_missing_effect(plain, bar, lives):
    """The fit knew it to a per cent; a fifth more since is what has changed, and `improve` sets it right."""
    known = plain.known(("nut_friction.power",), np.array([[0.2**2]]))
    runs = Runs(bar, lives(plain.with_values({"nut_friction.power": 24.0}))[:2])
    steps = improve(known, runs, Runs(bar, []), list(CATALOGUE.values())).steps
    assert [step.added for step in steps] == ["", ""]
    assert steps[-1].model["nut_friction.power"] == pytest.approx(24.0, rel=0.02)


def test_an_effect_that_does_what_an_own_parameter_does_is_that_parameter(plain, bar, lives):
    """The fit knew the nut's exponent, and it is another one since."""
    known, other = plain.known(("nut_friction.n",), np.array([[0.01**2]])), plain.with_values({"nut_friction.n": 1.15})
    found = suggest(known, Runs(bar, lives(other)), [CATALOGUE["nut_speed_exponent"]])
    assert (found.verdict, found.changed) == ("nothing_missing", "nut_friction.n")
    assert found.found[0].model["nut_friction.n"] == pytest.approx(1.15, abs=0.02)


def test_a_model_fitted_to_these_recordings_stands_on_tables_alone(plain, bar, lives):
    runs = Runs(bar, lives(with_effect(plain, "churning", share=0.5))[:2])
    known = plain.known(("nut_friction.power",), np.array([[0.2**2]]))
    assert as_given(known, runs).learned == {"nut_friction.power"}
    bent = replace(known, about={**known.about, "fitted_on": {"run 0": runs.recordings[0].fingerprint}})
    assert not as_given(bent, runs).learned
    assert suggest(bent, runs, [CATALOGUE["churning"]]).before.refit


class Clamp(Effect):
    """A clamp at the middle stores heat: C dT/dt = g (T_screw - T)."""

    capacity = Param(60.0, "J/K", lo=5.0, hi=500.0, sd=40.0)
    g = Param(1.0, "W/K", lo=0.0, hi=20.0, null=0.0)

    def terms(self, p, u, rig):
        yield Store("clamp", p.capacity, 1.0)
        middle = rig.screw.overlap(80.0, 120.0)
        yield Link(SCREW, "clamp", p.g * middle / middle.sum())


def test_what_stores_heat_is_found_with_its_size(plain, bar, lives):
    """Its conductance is told by quick changes alone, and by few thermometers."""
    truth = (plain + Clamp).with_values({"clamp.capacity": 80.0, "clamp.g": 2.0})
    found = suggest(plain, Runs(bar, lives(truth)[:3]), [Clamp])
    assert (found.verdict, found.found[0].names) == ("effect", ("clamp",))
    assert found.found[0].model["clamp.capacity"] == pytest.approx(80.0, rel=0.2)
    assert found.found[0].own()["clamp.g"].value == pytest.approx(2.0, abs=2 * found.found[0].own()["clamp.g"].sd)


def test_nothing_planted_is_nothing_missing_and_no_input_wrong(searched):
    _, found = searched["nothing"]
    assert (found.verdict, found.changed, found.wrong_input) == ("nothing_missing", "", None)
    assert not [name for h in found.found for name in inputs_in(h.names)]
    assert found.as_given.misfit < 1.0


def test_radiation_and_still_air_are_a_tie(plain, bar, lives):
    """Where nobody knows the still air: a table value that it would be far from decides for radiation."""
    plain = plain.with_values({"still_air.h": replace(plain.values["still_air.h"], prior=Prior(8.0, 50.0))})
    found = search(plain, bar, lives(with_effect(plain, "radiation", emissivity=0.8))[:2])
    assert found.verdict == "tie"
    assert set(found.tie) == {"radiation", "still_air"}


def test_what_no_catalogue_has_is_placed_and_followed(plain, bar, lives):
    follows = followers(bar).index(REST)
    found = search(plain, bar, lives(with_effect(plain, "unknown_heat", power=4.0, at=60.0, follows=follows))[:2])
    assert found.verdict == "nothing_in_catalogue"
    at = found.unexplained.candidate.at
    assert at["unknown_heat.at"] == pytest.approx(60.0, abs=30.0)
    assert at["unknown_heat.follows"] == follows


class Jet(Effect):
    """A jet takes heat from the screw at 60 mm while it turns."""

    g = Param(0.5, "W/K", lo=0.0, hi=20.0, null=0.0)

    def terms(self, p, u, rig):
        at = rig.screw.overlap(50.0, 70.0)
        yield Link(SCREW, "ambient", p.g * (u.omega > 0.5) * at / at.sum())


def test_what_a_jet_takes_goes_by_the_temperature_while_the_screw_turns(plain, bar, lives):
    found = suggest(plain, Runs(bar, lives(plain + Jet)[:3]), [], taken=())
    unknown = unknown_of(found.unexplained.candidate, bar)
    assert (found.verdict, unknown.follower) == ("nothing_in_catalogue", LOSS_DRIVE)
    assert unknown.at_mm == pytest.approx(60.0, abs=5.0)
    assert found.composed.hypothesis.misfit < GOOD


def test_heat_that_grows_with_the_temperature_there_can_be_tried(plain, bar, lives):
    """Its link conducts the wrong way, which no effect of a user's own may."""
    follows = followers(bar).index(TEMPERATURE)
    growing, steady = (
        with_effect(plain, "unknown_heat", power=power, at=60.0, follows=follows) for power in (-0.2, 0.0)
    )
    trial = unjudged(steady, bar, lives(plain)[0])
    warmer = trial.pose(growing).run.lagged[-1] - trial.pose(steady).run.lagged[-1]
    assert warmer[1] > 0.05


def test_beside_what_is_missing_a_fixed_parameter_may_be_another_machines(plain, bar, lives):
    """Held at another machine's exponent, the effect would have to make up for it."""
    held = plain.with_values({"nut_friction.n": replace(plain.values["nut_friction.n"], fixed=True)})
    truth = with_effect(plain.with_values({"nut_friction.n": 1.3}), "local_heat", at=60.0)
    found = search(held, bar, lives(truth))
    assert (found.verdict, found.found[0].names) == ("effect", ("local_heat",))
    assert found.loosened == ["nut_friction.n"]
    assert found.found[0].model["nut_friction.n"] == pytest.approx(1.3, abs=0.02)
    assert found.found[0].misfit < GOOD


def test_a_model_that_holds_nothing_fixed_is_fitted_again_once(plain, bar, lives):
    found = suggest(plain, Runs(bar, lives(plain)[:2]), [])
    assert found.verdict == "nothing_missing"
    assert not found.loosened


def test_what_a_thermometer_follows_that_is_left_out_is_told(rig, full, live, driven):
    """Its jumps keep step with the drive: no fault, though everything else is well without it."""
    at, runs = rig.index("T06"), []
    for k, speed in enumerate((FAST, FAST / 2)):
        run = live(full, rig, driven(rig, 1500, (300, 900), speed), seed=k).recording
        channels = run.channels.copy()
        channels[:, at] += 0.5 * (run.omega > 0)
        runs.append(replace(run, channels=channels, name=f"run {k}"))
    found = suggest(full, Runs(rig, runs), [], taken=())
    unknown = unknown_of(found.unexplained.candidate, rig)
    assert (found.verdict, found.believed) == ("nothing_in_catalogue", ("T06",))
    assert (unknown.channel, unknown.follower) == ("T06", DRIVE)
    assert found.composed.hypothesis.own()["shift_of_t06.shift"].value == pytest.approx(0.5, abs=0.02)


def test_what_all_thermometers_follow_is_told_though_the_judge_counts_them_from_another_zero(rig, full, live, driven):
    """They jump together with each stop; and though a law of the catalogue explains a part of it."""
    runs = []
    for k, speed in enumerate((FAST, FAST / 2)):
        run = live(full, rig, driven(rig, 2400, (300, 900), speed), seed=k).recording
        since_s = run.time_s - 900.0
        board = run.inputs["board"] + 3.0 * (1.0 - np.exp(-run.time_s / 2000.0))
        shift = np.where(since_s > 0, 0.5 * np.exp(-since_s / 200.0), 0.0)
        channels = run.channels + np.outer(shift, rig.is_thermometer)
        runs.append(replace(run, channels=channels, name=f"run {k}", inputs={**run.inputs, "board": board}))
    found = suggest(full, Runs(rig, runs), [CATALOGUE["board_drift"]], taken=())
    unknown = unknown_of(found.unexplained.candidate, rig)
    assert (found.verdict, {*found.believed} >= {"T05", "T06", "T07"}) == ("nothing_in_catalogue", True)
    assert (unknown.channel, unknown.follower.name) in (("", "early_stop"), ("", "slow_stop"))


@pytest.mark.parametrize("heard", [True, False])
def test_what_a_thermometer_follows_that_drifts_in_every_run_is_told(rig, full, live, driven, monkeypatch, heard):
    """It is left out as one that fails, but comes back with every run. The judge is one that hears less of it."""
    at, runs, spell = rig.index("T06"), [], (Spell(Fault.DRIFTING, 1000.0, float("nan")),)
    for k, speed in enumerate((FAST, FAST / 2)):
        run = live(full, rig, driven(rig, 5400, (300, 900), speed), seed=k).recording
        since_s, channels = run.time_s - 900.0, run.channels.copy()
        channels[:, at] += np.where(since_s > 0, 0.6 * (1.0 - np.exp(-since_s / 1600.0)), 0.0)
        runs.append(replace(run, channels=channels, name=f"run {k}"))

    def judged(model, runs, believed=()):
        trials = slow_trials_of(model, runs, believed)
        if "T06" in believed:
            return trials
        for trial in trials:
            trial.rest.channels[trial.rest.time_s > 1000.0, at] = np.nan
        uses = [
            replace(u, channels=tuple(replace(c, spells=spell * (c.channel == "T06")) for c in u.channels))
            for u in trials.uses
        ]
        return Trials(list(trials), trials.workers, tuple(uses))

    monkeypatch.setattr(search_, "slow_trials_of", judged)
    if not heard:
        monkeypatch.setattr(search_, "drifts_always", lambda uses, rig: [])
    found = suggest(full, Runs(rig, runs), [], taken=())
    assert (found.verdict, found.believed) == (("nothing_in_catalogue", ("T06",)) if heard else ("nothing_missing", ()))
    assert not heard or unknown_of(found.unexplained.candidate, rig).channel == "T06"


def test_a_thermometer_that_is_stuck_in_every_run_hides_no_effect(rig, full, live, driven):
    """What it read before it was left out would need a law of its own."""
    truth, at, runs = full + CATALOGUE["churning"], rig.index("T06"), []
    for k, speed in enumerate((FAST, FAST / 2)):
        run = live(truth, rig, driven(rig, 2400, (300, 1500), speed), seed=k).recording
        channels = run.channels.copy()
        channels[:, at] = channels[0, at]
        runs.append(replace(run, channels=channels, name=f"run {k}"))
    found = suggest(full, Runs(rig, runs), [CATALOGUE["churning"]], taken=())
    assert (found.verdict, found.found[0].names) == ("effect", ("churning",))
