"""The battery bites: an effect that is wrong in one way fails the check of that, and says how."""

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


class Visible(Jet):
    """A jet that blows a little even where it should not.

    q = -P - 0.1 W
    """

    def terms(self, p, u, rig):
        yield Heat(SCREW, -p.power - 0.1, over=spot(rig, 350.0, 30.0))


class Unseen(Jet):
    """A jet that misses the screw.

    q = 0 P
    """

    def terms(self, p, u, rig):
        yield Heat(SCREW, 1e-9 * p.power)


class Switched(Jet):
    """A jet that is only there when it blows.

    q = -P
    """

    def terms(self, p, u, rig):
        if p.power != 0:
            yield Heat(SCREW, -p.power, over=spot(rig, 350.0, 30.0))


class Silent(Jet):
    """A jet without a word.

    q = -P
    """

    def terms(self, p, u, rig):
        yield from ()


class Absolute(Jet):
    """A jet that cools whatever the sign.

    q = -|P|
    """

    def terms(self, p, u, rig):
        yield Heat(SCREW, -np.abs(p.power), over=spot(rig, 350.0, 30.0))


class Stored(Jet):
    """A jet whose power goes through an array of real numbers.

    q = -P
    """

    def terms(self, p, u, rig):
        q = np.zeros((len(u), 1))
        q[:] = -p.power * np.ones_like(q)
        yield Heat(SCREW, q, over=spot(rig, 350.0, 30.0))


class Compared(Jet):
    """A jet that stops above 40 W.

    q = -P where P < 40 W
    """

    def terms(self, p, u, rig):
        yield Heat(SCREW, -p.power if p.power < 40.0 else 0.0, over=spot(rig, 350.0, 30.0))


class Rooted(Jet):
    """A jet whose root is no number.

    q = -P + sqrt(P / 5 - 1)
    """

    power = Param(5.0, "W", lo=-50.0, hi=50.0, source="a guess")

    def terms(self, p, u, rig):
        yield Heat(SCREW, -p.power + np.sqrt(np.reshape(p.power / 5.0 - 1.0, (1, 1))), over=spot(rig, 350.0, 30.0))


class Spare(Jet):
    """A jet with a parameter too many.

    q = -P
    """

    width = Param(30.0, "mm", lo=5.0, hi=50.0, source="a guess")


class Counting(Jet):
    """A jet that blows harder each time that it is asked.

    q = -P k
    """

    asked = count(1)

    def terms(self, p, u, rig):
        yield Heat(SCREW, -p.power * next(self.asked), over=spot(rig, 350.0, 30.0))


class Backwards(Jet):
    """A surface that takes heat from what is colder.

    q = -P (T - T_air) / K
    """

    power = Param(1.0, "W/K", lo=-5.0, hi=5.0, null=0.0, source="a guess")

    def terms(self, p, u, rig):
        yield Link(SCREW, "ambient", -p.power * spot(rig, 350.0, 30.0))


class Elsewhere(Jet):
    """A jet into a body that is not there.

    q = -P
    """

    def terms(self, p, u, rig):
        yield Heat("nutt", -p.power)


class Misspelt(Jet):
    """A jet with a slip of the pen.

    q = -P
    """

    def terms(self, p, u, rig):
        yield Heat(SCREW, -p.pwer)


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
        "nut_friction", "nut_speed_exponent", "friction_thinning", "churning",
    }  # fmt: skip
    assert all(finding.ok for finding in battery(CATALOGUE["nut_friction"], every, rig))


def test_heat_into_a_body_that_the_model_lacks_need_not_be_seen(full, rig):
    bare = full - "nut_flange" - "nut_body"
    found = {finding.check: finding for finding in battery(CATALOGUE["nut_friction"], bare, rig)}
    assert all(finding.ok for finding in found.values())
    assert found["seen off null"].detail == "power_nut = 50 leaves nothing in any reading"
