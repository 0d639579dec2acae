"""The battery bites: an effect that is wrong in one way fails the check of that, and says how."""

from collections.abc import Callable
from itertools import count

import numpy as np
import pytest

from estimator.battery.battery import CHECKS, battery
from estimator.battery.bench import without
from estimator.effect import Effect, Param
from estimator.effects import CATALOGUE
from estimator.effects.local import spot
from estimator.network import assemble
from estimator.terms import SCREW, Heat, Link


class Jet(Effect):
    """A jet of air cools one place.

    q = -P around x = 350 mm
    """

    power = Param(5.0, "W", lo=-50.0, hi=50.0, null=0.0, source="a guess")

    def terms(self, p, u, rig):
        yield Heat(SCREW, -p.power, over=spot(rig, 350.0, 30.0))


def jet(name: str, sentence: str, equation: str, q: Callable, **own: object) -> type[Effect]:
    """A jet that is wrong: of another heat q at the same place, or of what else `own` has."""
    terms = own.pop("terms", lambda self, p, u, rig: [Heat(SCREW, q(p, u), over=spot(rig, 350.0, 30.0))])
    return type(name, (Jet,), {"__doc__": f"A jet {sentence}.\n\nq = {equation}", "terms": terms, **own})


class Switched(Jet):
    """A jet that is only there when it blows.

    q = -P
    """

    def terms(self, p, u, rig):
        if p.power != 0:
            yield Heat(SCREW, -p.power, over=spot(rig, 350.0, 30.0))


class Stored(Jet):
    """A jet whose power goes through an array of real numbers.

    q = -P
    """

    def terms(self, p, u, rig):
        q = np.zeros((len(u), 1))
        q[:] = -p.power * np.ones_like(q)
        yield Heat(SCREW, q, over=spot(rig, 350.0, 30.0))


class Backwards(Jet):
    """A surface that takes heat from what is colder.

    q = -P (T - T_air) / K
    """

    power = Param(1.0, "W/K", lo=-5.0, hi=5.0, null=0.0, source="a guess")

    def terms(self, p, u, rig):
        yield Link(SCREW, "ambient", -p.power * spot(rig, 350.0, 30.0))


def rooted(p, u):
    return -p.power + np.sqrt(np.reshape(p.power / 5.0 - 1.0, (1, 1)))


def into_nutt(self, p, u, rig):
    yield Heat("nutt", -p.power)


NO_NULL = Param(5.0, "W", lo=-50.0, hi=50.0, source="a guess")
WIDTH = Param(30.0, "mm", lo=5.0, hi=50.0, source="a guess")
ASKED = count(1)

Visible = jet("Visible", "that blows a little even where it should not", "-P - 0.1 W", lambda p, u: -p.power - 0.1)
Unseen = jet("Unseen", "that is hardly one", "0 P", lambda p, u: 1e-9 * p.power)
Silent = jet("Silent", "without a word", "-P", None, terms=lambda *_: ())
Absolute = jet("Absolute", "that cools whatever the sign", "-|P|", lambda p, u: -np.abs(p.power))
Compared = jet("Compared", "that stops above 40 W", "-P", lambda p, u: -p.power if p.power < 40.0 else 0.0)
Rooted = jet("Rooted", "whose root is no number", "-P + sqrt(P / 5 - 1)", rooted, power=NO_NULL)
Spare = jet("Spare", "with a parameter too many", "-P", lambda p, u: -p.power, width=WIDTH)
Counting = jet("Counting", "that blows harder whenever it is asked", "-P k", lambda p, u: -p.power * next(ASKED))
Elsewhere = jet("Elsewhere", "into a body that is not there", "-P", None, terms=into_nutt)
Misspelt = jet("Misspelt", "with a slip of the pen", "-P", lambda p, u: -p.pwer)


class WithoutEquation(Jet):
    """A jet without an equation."""


class WithoutSentence(Jet):
    """A jet whose sentence

    q = -P goes on
    """


class WithoutUnits(Jet):
    """A jet of which nothing is known.

    q = -P
    """

    power = Param(5.0, "", null=-1e9)


BROKEN = [
    (Visible, "invisible at null", "with its parameters at null the readings are "),
    (Unseen, "seen off null", "power = 5 leaves nothing in any reading"),
    (Switched, "structure", "with power = 0 it yields other terms than by default"),
    (Silent, "fits the rig", "yields no term; yield one with 0 rather than none"),
    (Absolute, "derivative", "power: the complex step of q of term 1 is not its slope"),
    (Stored, "derivative", "ComplexWarning: Casting complex values to real"),
    (Compared, "derivative", "TypeError: '<' not supported between instances of 'complex' and 'float'"),
    (Rooted, "derivative", "q of term 1 is no number at power = 4.9995"),
    (Spare, "derivative", "width changes nothing"),
    (Counting, "order", "readings change by "),
    (Backwards, "fits the rig", "term 1, Link of screw - ambient: g is -"),
    (Elsewhere, "fits the rig", "a Heat is in 'nutt', which no effect of the model stores; did you mean 'nut'?"),
    (Misspelt, "fits the rig", "AttributeError: 'types.SimpleNamespace' object has no attribute 'pwer'"),
    (WithoutEquation, "documented", "the docstring has no equation"),
    (WithoutSentence, "documented", "the docstring's first line is no sentence of one line that ends with '.'"),
    (WithoutUnits, "documented", "power has no unit; power has no source; power has no finite bounds: lo = -inf"),
]

ALSO = {  # what else is wrong with it then
    Switched: {"invisible at null", "seen off null"},
    Counting: {"derivative"},
    WithoutUnits: {"invisible at null"},
}


def test_an_effect_that_is_right_passes(full, rig):
    found = battery(Jet, full, rig)
    assert [finding.check for finding in found] == list(CHECKS)
    assert all(finding.ok and finding.detail == "" for finding in found)


@pytest.mark.parametrize(("effect", "check", "detail"), BROKEN, ids=lambda v: getattr(v, "__name__", None))
def test_a_broken_effect_fails_its_check(effect, check, detail, full, rig):
    found = {finding.check: finding for finding in battery(effect, full, rig)}
    assert not found[check].ok
    assert detail in found[check].detail
    assert {name for name, finding in found.items() if not finding.ok} == {check, *ALSO.get(effect, ())}


def test_what_does_not_fit_the_rig_is_not_checked_further(full, rig):
    assert [finding.check for finding in battery(Elsewhere, full, rig)] == ["documented", "fits the rig"]


def test_a_link_of_the_catalogue_that_conducts_backwards_is_found(full, rig, monkeypatch):
    """Of a user's own it is found with the first terms that they yield."""
    monkeypatch.setattr(Backwards, "__module__", "estimator.effects.local")
    (found,) = (finding for finding in battery(Backwards, full, rig) if finding.check == "heat is kept")
    assert found.detail == "a link conducts backwards: its g is below 0"


def test_a_leaking_link_is_found(full, rig, monkeypatch):
    """The vocabulary has no link that loses heat; a mistake in the assembly would be one."""
    link = assemble._link

    def leaking(conductance, inflow, place, term):
        link(conductance, inflow, place, term)
        inflow *= 0.9

    monkeypatch.setattr(assemble, "_link", leaking)
    found = {finding.check: finding for finding in battery(CATALOGUE["still_air"], full, rig)}
    assert found["heat is kept"].detail == "its links lose heat on the way"


def test_the_model_may_have_the_effect_and_what_scales_it(every, rig):
    assert set(every.effects) - set(without(every, "nut_friction", rig).effects) == {
        "nut_friction", "nut_speed_exponent", "friction_thinning", "warm_grease", "churning",
    }  # fmt: skip
    assert all(finding.ok for finding in battery(CATALOGUE["nut_friction"], every, rig))


def test_heat_into_a_body_that_the_model_lacks_need_not_be_seen(full, rig):
    bare = full - "nut_flange" - "nut_body"
    found = {finding.check: finding for finding in battery(CATALOGUE["nut_friction"], bare, rig)}
    assert all(finding.ok for finding in found.values())
    assert found["seen off null"].detail == "power_nut = 50 leaves nothing in any reading"
