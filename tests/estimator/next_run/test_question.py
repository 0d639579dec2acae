"""What a verdict leaves open, for each of them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from estimator.accuracy.noise_floor import Error
from estimator.effects import CATALOGUE
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.hypothesis import Hypothesis
from estimator.hypotheses.panel import Explanation
from estimator.missing_effect.suggestion import Suggestion
from estimator.next_run.question import ALONE, badly_known, question

NAMES = ("radiation", "churning", "sensor_lag")
BLOCKS = np.ones((2, 2, 4))


@pytest.fixture
def stub(plain):
    """stub(misfit, *names): a hypothesis that leaves so much in each of two recordings."""

    def of(misfit: float, *names: str, sd: float = 0.01) -> Hypothesis:
        model = plain
        for name in names:
            model = model + CATALOGUE[name]
        paths = tuple(next(p for p in model.free() if p.startswith(f"{name}.")) for name in names)
        judged = Explanation(
            (), np.zeros(0), sd**2 * np.eye(len(paths)), misfit, 10.0, Error(misfit, misfit), misfit,
            np.full(2, misfit), misfit * BLOCKS, misfit,
        )  # fmt: skip
        return Hypothesis(names, Ground(plain, ()), model, paths, judged, told=0.0)

    return of


@pytest.fixture
def asked(stub, bar):
    """asked(verdict, *hypotheses, **more): why, and between whom."""

    def of(verdict: str, *found: Hypothesis, **more):
        plain = stub(1.0)
        suggestion = Suggestion(verdict, found, more.pop("tie", ()), plain, plain, plain, (), **more)
        open_ = question(suggestion, bar, list)
        return open_ and (open_.why, [name for name, _ in open_.rivals])

    return of


def test_a_tie_of_any_size_is_open_between_all_of_it(asked, stub):
    three = [stub(0.2 + 0.01 * i, name) for i, name in enumerate(NAMES)]
    assert asked("tie", *three, tie=NAMES) == ("tie", [*NAMES])
    assert asked("tie", *three, tie=NAMES[:2]) == ("tie", [*NAMES[:2]])


def test_a_pair_is_held_against_either_alone(asked, stub):
    pair, single = stub(0.2, "radiation", "churning"), stub(0.5, "churning")
    assert asked("effects", pair, single, stub(0.4, "sensor_lag")) == ("pair", ["radiation and churning", "churning"])
    assert asked("effects", pair) == ("pair", ["radiation and churning", ALONE])


def test_an_effect_is_open_where_its_size_is_hardly_known(asked, stub):
    assert asked("effect", stub(0.2, "radiation")) is None
    vague = stub(0.2, "radiation", sd=0.3)
    assert badly_known(vague) == "radiation.emissivity"
    assert asked("effect", vague) == ("badly known", ["radiation"])


def test_what_is_not_proven_is_open_where_it_is_worth_having(asked, stub):
    assert asked("nothing_missing", stub(0.9, "radiation")) == ("not proven", ["radiation", ALONE])
    assert asked("nothing_missing", stub(1.0, "radiation")) is None
    assert asked("nothing_missing", stub(0.9, "radiation"), changed="still_air.h") is None
    little = stub(0.9, "radiation")
    little = replace(little, judged=replace(little.judged, error=Error(0.9999, 1.0), read_um=1.0))
    assert asked("nothing_missing", little) is None


def test_what_nothing_explains_asks_for_what_explains_most(asked, stub):
    assert asked("nothing_in_catalogue", stub(0.9, "radiation")) == ("partly", ["radiation", ALONE])
    assert asked("nothing_in_catalogue") is None


def test_a_wrong_input_is_looked_at_first(asked, stub):
    assert asked("input_error", stub(0.2, "radiation"), wrong_input=SimpleNamespace()) is None
