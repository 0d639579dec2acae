"""Which hypotheses on one ground are named, told by what they leave."""

from dataclasses import dataclass, field

import pytest

from estimator.hypotheses.panel import Explanation
from estimator.missing_effect.side import Side
from tests.estimator.hypotheses.test_criterion import explanation


@dataclass(frozen=True)
class Told:
    """A hypothesis of which nothing is known but what it leaves."""

    names: tuple[str, ...]
    judged: Explanation
    freed: str = ""
    misfit: float = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "misfit", self.judged.misfit)

    def at_bound(self) -> list[str]:
        return []


def told(name: str, misfit: float, freed: str = "") -> Told:
    return Told((name,), explanation(misfit, 0.8 * misfit, 1), freed)


@pytest.fixture
def side():
    """A hundred readings of which a model leaves 3, where the best of a hundred hypotheses has to leave 2.58."""

    def of(*effects: Told, own: tuple[Told, ...] = ()) -> Side:
        made = object.__new__(Side)
        made.plain, made.tried, made.fitted, made.own = told("", 3.0), 100, list(effects), list(own)
        return made

    return of


def test_what_is_as_likely_as_the_best_is_named_though_it_is_not_proven(side):
    """Of 100 readings a twentieth of the likelihood is 1.06 times the misfit."""
    found = side(told("churning", 2.5), told("radiation", 2.7), own=(told("nut_body", 2.62, "nut_body.g_air"),))
    assert [h.names[0] for h in found.missing] == ["churning"]
    assert [h.names[0] for h in found.told] == ["churning", "nut_body"]


def test_beside_a_parameter_of_another_value_no_effect_is_named_that_is_not_proven(side):
    found = side(told("churning", 2.62), own=(told("nut_body", 2.5, "nut_body.g_air"),))
    assert [h.names[0] for h in found.told] == ["nut_body"]


@pytest.mark.parametrize(("left", "named"), [(1.4, ["speed_scale"]), (1.6, [])])
def test_an_input_is_wrong_where_setting_it_right_takes_most_of_the_misfit_off(side, left, named):
    assert [h.names[0] for h in side(told("speed_scale", left)).told] == named


@pytest.mark.parametrize(("left", "found"), [(1.4, True), (1.6, False)])
def test_so_it_is_beside_an_effect(side, left, found, monkeypatch):
    both = Told(("churning", "speed_scale"), explanation(left, 0.8 * left, 2))
    for name, answer in (("_few", []), ("_pairs", []), ("_to_fit", [both])):
        monkeypatch.setattr(Side, name, lambda *_, answer=answer: answer)
    for name, answer in (("material", True), ("too_small", False)):
        monkeypatch.setattr(f"{Side.__module__}.{name}", lambda *_, answer=answer: answer)
    monkeypatch.setattr(f"{Side.__module__}.refined", lambda ground, trials, two: two)
    made = side(told("churning", 2.5))
    made.ground = made.trials = None
    assert (made.pair is both) == found
