"""No verdict hangs on a constant: each may be a third more or less."""

from dataclasses import replace

import pytest

from estimator.batch.trials import slow_trials_of
from estimator.effects import CATALOGUE
from estimator.hypotheses import criterion
from estimator.hypotheses.ground import Ground
from estimator.inputs.follower import REST, followers
from estimator.missing_effect import begun, odd_run, side, suggest, wrong_input
from estimator.missing_effect.suggest import Search
from estimator.missing_effect.wrong_input import ZERO
from estimator.model import Prior
from estimator.work import Runs
from tests.estimator.conftest import Chips, with_effect

pytestmark = pytest.mark.study

CRITERION = ("CHANCE", "APART_SE", "WORTH_K", "WORTH_UM", "GOOD", "FAR")
SHARES = (0.7, 1.3)


@pytest.fixture(scope="module")
def searches(plain, bar, lives):
    """A search for each kind of verdict, and what it comes to."""
    air = replace(plain.values["still_air.h"], prior=Prior(8.0, 50.0))
    unknown = plain.with_values({"still_air.h": air})
    rest = followers(bar).index(REST)
    hidden = {
        "nothing_missing": (plain, plain),
        "effect": (plain, with_effect(plain, "churning", share=0.5)),
        "tie": (unknown, with_effect(unknown, "radiation", emissivity=0.8)),
        "nothing_in_catalogue": (plain, with_effect(plain, "unknown_heat", power=4.0, at=60.0, follows=rest)),
    }
    return {
        verdict: Search(model, Runs(bar, lives(truth)), list(CATALOGUE.values()), (), told=False)
        for verdict, (model, truth) in hidden.items()
    }


@pytest.fixture(scope="module")
def stand_ins():
    """What explains most of what no catalogue has, by recordings: looked for once, for no constant changes it."""
    return {}


@pytest.fixture
def looked_once(monkeypatch, stand_ins):
    """Stand-ins are looked for once, and no effect is composed of them: the verdict stands before that."""
    look = suggest.best_stand_in

    def once(ground, trials):
        key = id(trials), ground.refit
        if key not in stand_ins:
            stand_ins[key] = look(ground, trials)
        return stand_ins[key]

    monkeypatch.setattr(suggest, "best_stand_in", once)
    monkeypatch.setattr(suggest, "composed", lambda *_: None)


def vary(monkeypatch, name, share):
    """A constant wherever it is used."""
    for module in (criterion, suggest, side, odd_run, begun):
        if hasattr(module, name):
            monkeypatch.setattr(module, name, share * getattr(module, name))


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("name", CRITERION)
@pytest.mark.usefixtures("looked_once")
def test_verdicts_hold(name, share, searches, monkeypatch):
    vary(monkeypatch, name, share)
    for verdict, search in searches.items():
        for one in search.sides:
            one.__dict__.pop("missing", None)
            one.__dict__.pop("pair", None)
        assert search.run().verdict == verdict


@pytest.mark.parametrize("share", SHARES)
def test_the_same_ground_holds(share, searches, monkeypatch):
    """Whether the other is fitted in full may hang on it."""
    search = searches["effect"]
    refit = search.side.plain.refit
    vary(monkeypatch, "PROMISE", share)
    search.__dict__.pop("sides")
    assert search.side.plain.refit == refit


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("name", ["ODD", "BAD", "LEAST_GAIN"])
def test_the_same_run_is_unlike_the_others(name, share, plain, bar, lives, monkeypatch):
    vary(monkeypatch, name, share)
    clean, ground = lives(plain), Ground(plain, ())
    runs = Runs(bar, [clean[0], lives(plain + Chips)[1], *clean[2:]])
    trials = slow_trials_of(plain, runs)
    assert odd_run.odd_run(ground, trials) == 1
    assert odd_run.odd_run(ground, slow_trials_of(plain, Runs(bar, clean))) is None
    if name == "LEAST_GAIN":
        assert begun.begun(ground, runs, trials, 1).events


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize(
    ("scale", "signal", "size"), [("LOG", "speed", 0.18), ("KELVIN", "ambient", 3.0), ("MM", ZERO, 30.0)]
)
def test_the_same_input_is_wrong(scale, signal, size, share, plain, bar, lives, monkeypatch):
    sure = getattr(wrong_input, scale)
    monkeypatch.setattr(wrong_input, scale, replace(sure, sure=share * sure.sure))
    runs = lives(plain)
    runs[1] = wrong_input.corrected(runs[1], bar, signal, -size)
    runs = Runs(bar, runs)
    found = wrong_input.mislabel(Ground(plain, ()), runs, slow_trials_of(plain, runs), 1)
    assert found.signal == ("position" if signal == ZERO else signal)
