"""A model that does not fit its rig says so in one line: model, effect, what is wrong, what was meant."""

from dataclasses import replace

import pytest

from estimator.effect import Effect, Param
from estimator.errors import SetupError
from estimator.inputs.start import Start
from estimator.model import model_of
from estimator.network.check import asks_for
from estimator.network.forcing import Forcing
from estimator.terms import Chain, Heat, Lag, Link, Read, Store

START = Start(22.0, 0.0, {})


def test_a_model_asks_for_what_it_does_nothing_without(small, small_model):
    class Warmer(Effect):
        """Heats the nut with what is told: q = P."""

        def terms(self, p, u, rig):
            yield Heat("nut", u["position"])

    assert asks_for(small_model + Warmer, small, "position")
    assert not asks_for(small_model, small, "position")


def cup_and(*terms) -> type[Effect]:
    """An effect that stores heat in a cup, and says something more."""

    class Odd(Effect):
        """Says something impossible: 1 = 2."""

        def terms(self, p, u, rig):
            yield Store("cup", 5.0, 1.0)
            yield from (term(u) if callable(term) else term for term in terms)

    return Odd


@pytest.mark.parametrize(
    ("term", "message"),
    [
        (
            Link("cup", "ambiant", 1.0),
            "a Link ends at 'ambiant', which no effect of the model stores and small/rig.toml has not in [inputs]; "
            "did you mean 'ambient'?",
        ),
        (Heat("cap", 1.0), "a Heat is in 'cap', which no effect of the model stores; did you mean 'cup'?"),
        (Chain("cap", 1.0), "term 2, Chain of cap: a Chain is along the screw; between bodies there are Links"),
        (Read("T01"), "reads 'T01', which small/rig.toml has not in [channels]; did you mean 'T1'?"),
        (Lag("T01", 1.0), "reads 'T01', which small/rig.toml has not in [channels]; did you mean 'T1'?"),
        (
            Read("T1", {"cap": 1.0}),
            "channel 'T1' reads 'cap', which no effect of the model stores; did you mean 'cup'?",
        ),
        (
            lambda u: Link("cup", "ambient", u["ambiant"]),
            "needs the input 'ambiant', which rig.toml has not in [inputs]; did you mean 'ambient'?; add it or leave "
            "the effect out",
        ),
        (
            lambda u: Link("cup", "ambient", 1 + u["ambient"]),
            "the g of a Link depends on an input; "
            "it may depend on parameters, u.omega, u.unevenness, u.idle and u.coverage only",
        ),
    ],
)
def test_what_an_effect_gets_wrong_is_named(small, term, message):
    with pytest.raises(SetupError) as caught:
        Forcing(model_of([cup_and(term)], "m.toml"), small, START)
    assert str(caught.value) == f"m.toml: odd: {message}"


def test_a_node_is_stored_once(small):
    with pytest.raises(SetupError, match=r"^model: odd: node 'cup' is stored twice, by odd too; one decl"):
        Forcing(model_of([cup_and(Store("cup", 6.0, 1.0))]), small, START)


def test_an_effect_without_terms_says_so(small):
    class Empty(Effect):
        """Says nothing: 0 = 0."""

    with pytest.raises(SetupError, match=r"^model: empty: effect empty: 'terms' is missing$"):
        Forcing(model_of([Empty]), small, START)


@pytest.mark.parametrize(
    ("lacking", "effect", "key"),
    [
        ({"screw": None}, "conduction", "screw"),
        ({"nut": None}, "nut_friction", "nut"),
        ({}, "anchor_friction", "supports.anchor"),
    ],
)
def test_a_rig_that_lacks_what_an_effect_needs_is_named(small, full, lacking, effect, key):
    with pytest.raises(SetupError) as caught:
        Forcing(full, replace(small, **lacking), START)
    assert str(caught.value) == (
        f"full: {effect}: needs [{key}], which small has not; add it to rig.toml or leave the effect out"
    )


class Leak(Effect):
    """A cup leaks the more the warmer the air is: which a Link cannot say, and does not where g is 0."""

    g = Param(0.0, "W/K", null=0.0)

    def terms(self, p, u, rig):
        yield Store("cup", 5.0, 1.0)
        yield Link("cup", "ambient", p.g * (1 + u["ambient"]))


def test_an_effect_of_one_s_own_is_asked_again_at_other_values(small):
    model = replace(model_of([Leak]), use={"leak": "effects.py:Leak"})
    begun = Forcing(model, small, START)
    with pytest.raises(SetupError, match="the g of a Link depends on an input"):
        begun.with_model(model.with_values({"leak.g": 1.0}))


def test_an_effect_that_was_not_there_before_is_asked(small):
    begun = Forcing(model_of([cup_and()]), small, START)
    with pytest.raises(SetupError, match="reads 'T01', which small"):
        begun.with_model(model_of([cup_and(Read("T01"))]))
