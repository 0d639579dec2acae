"""Finding what is missing, on recordings that a model with one effect more has lived."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.trials import slow_trials_of
from estimator.effect import Effect, Param
from estimator.effects import CATALOGUE
from estimator.inputs.follower import REST, followers
from estimator.missing_effect.candidates import candidates, kind_of, places
from estimator.missing_effect.ground import Ground, as_given
from estimator.missing_effect.hypothesis import refined
from estimator.missing_effect.improve import improve
from estimator.missing_effect.moments import Column, moments
from estimator.missing_effect.next_run import next_run
from estimator.missing_effect.panel import Panel
from estimator.missing_effect.screening import screening
from estimator.missing_effect.stand_ins import UnknownHeat
from estimator.missing_effect.suggest import suggest
from estimator.missing_effect.suggestion import Suggestion
from estimator.missing_effect.wrong_input import corrected, mislabel
from estimator.model import Model, Prior
from estimator.record import Recording
from estimator.rig import Rig, Signal
from estimator.terms import SCREW, Link, Store
from estimator.work import Runs

DRIVES = (  # rad/s, stroke mm, from s, to s
    (174.5, (0, 100), (20, 400)),
    (87.0, (20, 80), (20, 700)),
    (43.6, (0, 100), (20, 900)),
    (174.5, (40, 90), (20, 500)),
)
SECONDS = 1500

Lives = Callable[..., list[Recording]]


@pytest.fixture(scope="module")
def bar(small: Rig) -> Rig:
    """The small bar with a speed that is an input."""
    return replace(small, inputs={**small.inputs, "speed": Signal(unit="rpm")})


@pytest.fixture(scope="module")
def plain(small_model: Model) -> Model:
    """What is known of the bar: table values that are right for it, as well known as the catalogue says."""
    model = small_model.with_values(
        {"nut_friction.power": 20.0, "nut_friction.power_nut": 10.0, "thermometers.board": 0.0}
    )
    known = {path: value for path, value in model.values.items() if model.param(path).sd}
    priors = {path: Prior(value.value, model.param(path).sd) for path, value in known.items()}
    return model.with_values({path: replace(value, prior=priors[path]) for path, value in known.items()})


@pytest.fixture(scope="module")
def lives(bar, live, driven) -> Lives:
    """lives(model, seed): four runs that the model has lived, with scatter of the sensors."""

    def of(model: Model, seed: int = 1) -> list[Recording]:
        runs = []
        for k, (omega, stroke, drive) in enumerate(DRIVES):
            lived = live(model, bar, driven(bar, SECONDS, drive, omega, stroke), seed=seed + k)
            runs.append(replace(lived.recording, name=f"run {k}"))
        return runs

    return of


def with_effect(model: Model, name: str, **values: float) -> Model:
    wider = model + (UnknownHeat if name == "unknown_heat" else CATALOGUE[name])
    return wider.with_values({f"{name}.{key}": value for key, value in values.items()})


def search(plain: Model, bar: Rig, runs: Sequence[Recording]) -> Suggestion:
    return suggest(plain, Runs(bar, runs), CATALOGUE.values())


def test_candidates_fit_the_rig_and_are_absent(plain, bar):
    wide, found = candidates(plain, bar, CATALOGUE.values())
    names = {c.name for c in found}
    assert {"churning", "local_heat", "radiation", "sensor_lag", "expansion_error", "channel_gain"} <= names
    assert not names & set(plain.effects)
    assert not names & {"motor_heat", "anchor_housing", "bearing_speed_exponent"}  # no bearing on this bar
    assert sum(c.name == "channel_offset" for c in found) == len(bar.thermometers)
    assert sum(c.name == "local_heat" for c in found) == len(places(bar))
    for each in found:
        assert each.kind == kind_of(wide, each.name, bar)
    assert {c.name: c.kind for c in found}["sensor_lag"] == "reading"
    assert {c.name: c.kind for c in found}["base_drift"] == "heat"


def test_all_candidates_at_their_nulls_leave_the_model_as_it_is(plain, bar, lives):
    wide, _ = candidates(plain, bar, CATALOGUE.values())
    runs = lives(plain)[:1]
    (alone,), (beside,) = (
        moments(slow_trials_of(model, Runs(bar, runs)), model, []) for model in (plain, wide)
    )  # fmt: skip
    np.testing.assert_allclose(beside.heat, alone.heat, rtol=1e-9)


@pytest.fixture(scope="module")
def panel(plain, bar, lives) -> Panel:
    wide, found = candidates(plain, bar, [CATALOGUE["churning"], CATALOGUE["sensor_lag"]])
    runs = lives(with_effect(plain, "churning", share=0.1))
    paths = ["still_air.h", "nut_friction.power", *(path for c in found for path in c.paths)]
    columns = [Column(wide, path) for path in paths]
    return Panel(columns, moments(slow_trials_of(wide, Runs(bar, runs)), wide, columns))


def prior_of(panel: Panel) -> np.ndarray:
    """1 / sd^2 of each parameter; all are at their table values, or have none."""
    sds = [column.model.param(column.path).sd for column in panel.columns]
    return np.array([1.0 / sd**2 if sd else 0.0 for sd in sds])


def test_left_out_misfit_is_what_the_others_predict(panel):
    """Against least squares, priors and products written out."""
    chosen = [0, 1, 2]
    prior = prior_of(panel)[chosen]
    weighted = [m.weighted for m in panel.found]
    rests = []
    for out in range(len(weighted)):
        sums = sum(w for i, w in enumerate(weighted) if i != out)
        change = np.linalg.solve(sums[np.ix_(chosen, chosen)] + np.diag(prior), sums[chosen, -1])
        d = np.append(-change, 1.0)
        at = [*chosen, -1]
        rests.append(d @ weighted[out][np.ix_(at, at)] @ d)
    judged = panel.judge(chosen)
    unlikely = judged.change**2 @ prior
    assert judged.misfit == pytest.approx((sum(rests) + unlikely) / sum(m.weight for m in panel.found), rel=1e-5)
    assert judged.runs.sum() == pytest.approx(
        sum(r / m.weight for r, m in zip(rests, panel.found, strict=True)), rel=1e-5
    )


def test_gains_are_what_a_fit_takes_off(panel):
    whole, prior = sum(m.weighted for m in panel.found), prior_of(panel)
    for beside in ([], [0, 1]):
        gains = panel.gains(beside)
        for k in (2, 3):
            solved = {}
            for chosen in (beside, [*beside, k]):
                change = panel.judge(chosen).change
                d, at = np.append(-change, 1.0), [*chosen, -1]
                solved[len(chosen)] = d @ whole[np.ix_(at, at)] @ d + change**2 @ prior[chosen]
            taken = solved[len(beside)] - solved[len(beside) + 1]
            assert gains[k] == pytest.approx(taken, rel=1e-4, abs=1e-6)


def test_a_change_stays_inside_its_bounds(panel):
    judged = panel.judge([3])  # a lag cannot be negative
    assert panel.at[3] + judged.change[0] >= -1e-9


def test_the_screen_puts_the_planted_place_first(plain, bar, lives):
    runs = lives(with_effect(plain, "local_heat", power=2.0, at=150.0))
    wide, found = candidates(plain, bar, CATALOGUE.values())
    best = screening(Ground(plain, ()), wide, found, slow_trials_of(wide, Runs(bar, runs))).best()[0]
    assert best.candidate.name == "local_heat"
    assert best.candidate.at["local_heat.at"] == pytest.approx(150.0, abs=20.0)
    assert best.first["local_heat.power"] == pytest.approx(2.0, rel=0.3)


def test_a_fit_in_full_finds_place_and_size(plain, bar, lives):
    runs = lives(with_effect(plain, "local_heat", power=2.0, at=150.0))
    wide, found = candidates(plain, bar, [CATALOGUE["local_heat"]])
    seat = min(found, key=lambda c: abs(c.at["local_heat.at"] - 120.0))
    h = refined(Ground(plain, ()), slow_trials_of(wide, Runs(bar, runs)), [seat], {"local_heat.power": 1.0})
    values = h.known().values
    assert values["local_heat.at"].value == pytest.approx(150.0, abs=3.0)
    assert values["local_heat.power"].value == pytest.approx(2.0, rel=0.03)
    assert h.misfit < 1.0


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("churning", {"share": 0.5}),
        ("channel_offset", {"channel": 3, "offset": 0.4}),
    ],
)  # fmt: skip
def test_the_planted_effect_is_the_verdict(name, values, plain, bar, lives):
    found = search(plain, bar, lives(with_effect(plain, name, **values)))
    assert (found.verdict, found.found[0].names) == ("effect", (name,))
    for key, value in values.items():
        if f"{name}.{key}" in found.found[0].paths:
            assert found.found[0].model[f"{name}.{key}"] == pytest.approx(value, rel=0.3)


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
    new, healthy = lives(with_effect(plain, "churning", share=0.5)), lives(plain, seed=40)
    found = suggest(other, Runs(bar, new), CATALOGUE.values(), healthy=Runs(bar, healthy))
    assert (found.verdict, found.found[0].names) == ("effect", ("churning",))
    assert not found.before.refit
    assert found.as_given.ground.model["nut_friction.power"] == pytest.approx(20.0, rel=0.02)
    assert found.found[0].model["churning.share"] == pytest.approx(0.5, rel=0.2)


def test_a_parameter_of_another_value_is_no_missing_effect(plain, bar, lives):
    """The fit knew it to a per cent; a fifth more since is what has changed, and `improve` sets it right."""
    known = plain.known(("nut_friction.power",), np.array([[0.2**2]]))
    runs = Runs(bar, lives(plain.with_values({"nut_friction.power": 24.0})))
    found = suggest(known, runs, CATALOGUE.values())
    assert (found.verdict, found.changed) == ("nothing_missing", "nut_friction.power")
    steps = improve(known, runs, Runs(bar, []), list(CATALOGUE.values())).steps
    assert [step.added for step in steps] == ["", ""]
    assert steps[-1].model["nut_friction.power"] == pytest.approx(24.0, rel=0.02)


def test_a_model_fitted_to_these_recordings_stands_on_tables_alone(plain, bar, lives):
    runs = Runs(bar, lives(with_effect(plain, "churning", share=0.5)))
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
    found = suggest(plain, Runs(bar, lives(truth)), [Clamp])
    assert (found.verdict, found.found[0].names) == ("effect", ("clamp",))
    assert found.found[0].model["clamp.capacity"] == pytest.approx(80.0, rel=0.2)
    assert found.found[0].own()["clamp.g"].value == pytest.approx(2.0, abs=2 * found.found[0].own()["clamp.g"].sd)


def test_nothing_planted_is_nothing_missing(plain, bar, lives):
    found = search(plain, bar, lives(plain, seed=50))
    assert found.verdict == "nothing_missing"
    assert found.as_given.misfit < 1.0


def test_radiation_and_still_air_are_a_tie(plain, bar, lives):
    """Where nobody knows the still air: a table value that it would be far from decides for radiation."""
    plain = plain.with_values({"still_air.h": replace(plain.values["still_air.h"], prior=Prior(8.0, 50.0))})
    found = search(plain, bar, lives(with_effect(plain, "radiation", emissivity=0.8)))
    assert found.verdict == "tie"
    assert set(found.tie) == {"radiation", "still_air"}


def test_what_no_catalogue_has_is_placed_and_followed(plain, bar, lives):
    follows = followers(bar).index(REST)
    found = search(plain, bar, lives(with_effect(plain, "unknown_heat", power=4.0, at=60.0, follows=follows)))
    assert found.verdict == "nothing_in_catalogue"
    at = found.unexplained.candidate.at
    assert at["unknown_heat.at"] == pytest.approx(60.0, abs=30.0)
    assert at["unknown_heat.follows"] == follows


@pytest.mark.parametrize("wrong", ["speed", "speed and position"])
def test_a_wrong_label_names_run_and_signal(wrong, plain, bar, lives):
    runs = lives(plain)[:3]
    runs[1] = corrected(runs[1], bar, wrong, -np.log(1.2))
    found = search(plain, bar, runs)
    assert found.verdict == "input_error"
    assert (found.wrong_input.run, found.wrong_input.signal) == ("run 1", wrong)
    assert found.wrong_input.ratio == pytest.approx(1.2, abs=0.04)


def test_no_run_is_odd_where_all_fit_alike(plain, bar, lives):
    runs = lives(plain)
    assert mislabel(Ground(plain, ()), Runs(bar, runs), slow_trials_of(plain, Runs(bar, runs))) is None


def test_a_run_that_decides_sets_rivals_apart(plain, bar, lives):
    """Churning against a nut that simply rubs more: a long drive tells, since churning fades."""
    runs = lives(with_effect(plain, "churning", share=0.3))[:1]
    wide, found = candidates(plain, bar, [CATALOGUE["churning"]])
    trials = slow_trials_of(wide, Runs(bar, runs))
    churning = refined(Ground(plain, ()), trials, found, {"churning.share": 0.3})
    rubbing = refined(Ground(plain, ("nut_friction.power",)), trials, [])
    run = next_run(churning, rubbing, Runs(bar, runs))
    assert run.separation_sd > 3
    assert run.pattern in ("FS", "CS", "ES")
    itself = next_run(churning, churning, Runs(bar, runs))
    assert itself.separation_sd < 0.2


def test_improve_adds_both_of_two(plain, bar, lives):
    truth = with_effect(with_effect(plain, "churning", share=0.5), "local_heat", power=2.0, at=150.0)
    runs = lives(truth)
    found = improve(plain, Runs(bar, runs[:3]), Runs(bar, runs[3:]), list(CATALOGUE.values()))
    assert {step.added for step in found.steps} >= {"churning", "local_heat"}
    errors = [step.held_out.temperature_K for step in found.steps]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.1 * errors[0]
    assert found.last.verdict == "nothing_missing"


def test_what_an_earlier_step_added_moves_with_the_next(plain, bar, lives):
    """Churning alone took on a part of the local heat: its value is right again once both are there."""
    truth = with_effect(with_effect(plain, "churning", share=0.5), "local_heat", power=2.0, at=150.0)
    bent = with_effect(plain, "churning", share=0.6)
    wide, seats = candidates(bent, bar, [CATALOGUE["local_heat"]])
    runs = Runs(bar, lives(truth))
    trials = slow_trials_of(wide, runs)
    held, moved = (screening(Ground(bent, paths), wide, seats, trials) for paths in ((), ("churning.share",)))
    best = moved.best()[0]
    assert best.judged.misfit < 0.5 * held.best()[0].judged.misfit
    assert best.first["churning.share"] == pytest.approx(0.5, abs=0.03)
    found = suggest(bent, runs, [CATALOGUE["local_heat"]], loose=["churning"])
    assert found.as_given.paths == ("churning.share", "churning.decay", "churning.recovery")
    assert found.as_given.misfit < refined(Ground(bent, ()), trials, []).misfit
