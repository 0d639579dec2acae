"""What is kept of what `suggest` and `improve` said."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from benchmarks import paper_rig
from benchmarks.hidden.outcome import Outcome, of_improvement, of_suggestion
from estimator.accuracy.noise_floor import Error
from estimator.inputs.follower import SPEED, SPEED_SQUARED
from estimator.model import Model
from estimator.unknown.stand_ins import Unknown

MODEL = paper_rig.model()


def other(value: float) -> Model:
    """The model with another exponent of the nut."""
    return MODEL.with_values({"nut_friction.n": value})


def hypothesis(*names: str, n: float) -> SimpleNamespace:
    return SimpleNamespace(names=names, model=other(n))


def suggestion(verdict: str, **said: object) -> SimpleNamespace:
    """A verdict on a model whose own fit would have an exponent of 1.1."""
    silent = {"found": (), "tie": (), "pair": (), "changed": "", "wrong_input": None, "unexplained": None}
    silent |= {"composed": None, "uses": ()}
    return SimpleNamespace(**(silent | {"verdict": verdict, "before": hypothesis(n=1.1)} | said))


def kept(verdict: str, rig, **said: object) -> Outcome:
    return of_suggestion(suggestion(verdict, **said), MODEL, rig)


BOTH = (hypothesis("churning", n=1.2), hypothesis("nut_friction", n=1.3))


@pytest.mark.parametrize(
    ("verdict", "options", "said", "own", "values"),
    [
        ("nothing_missing", {"found": BOTH[:1]}, [], [], [1.1]),
        ("nothing_missing", {"found": BOTH[1:], "changed": "nut_friction.n"}, [], ["nut_friction"], [1.3]),
        ("effect", {"found": BOTH}, ["churning"], [], [1.2]),
        ("tie", {"found": BOTH, "tie": ("churning", "nut_friction")}, ["churning", "nut_friction"], None, [1.2, 1.3]),
        (
            "effects",
            {"found": (hypothesis("churning", "motor_heat", n=1.4),), "pair": ("churning", "motor_heat")},
            ["churning", "motor_heat"],
            [],
            [1.4],
        ),
    ],
)
def test_names_and_values_are_those_of_the_verdict(rig, verdict, options, said, own, values):
    out = kept(verdict, rig, **options)
    assert out.said == said
    assert out.own == (["nut_friction"] if own is None else own)
    assert out.values["nut_friction.n"] == values


def test_parameters_that_a_model_holds_are_kept(rig):
    held = of_suggestion(suggestion("nothing_missing"), paper_rig.model("base"), rig).held
    assert held["expansion_error.error"] == 0.0
    assert held["nut_friction.n"] == paper_rig.model("base")["nut_friction.n"]
    assert "still_air.h" not in held


def test_all_that_was_added_on_the_way_is_named():
    def step(added: str, um: float, *tie: str) -> SimpleNamespace:
        return SimpleNamespace(added=added, tie=tie, held_out=Error(um / 10.0, um))

    steps = (step("", 5.0), step("churning + motor_heat", 3.0), step("radiation", 1.0, "still_air"), step("", 0.5))
    done = SimpleNamespace(kept=steps, last=suggestion("nothing_missing"), uses=(), composed=(), model=other(1.25))
    out = of_improvement(done, MODEL)
    assert out.said == ["churning", "motor_heat", "radiation", "still_air"]
    assert out.own == ["still_air"]
    assert [out.before[1], out.after[1]] == [5.0, 0.5]
    assert out.values["nut_friction.n"] == [1.25]


def test_what_was_composed_is_kept_with_its_place_and_law():
    at = Unknown(SPEED_SQUARED, at_mm=310.0)
    made = SimpleNamespace(unknown=at, effect=SimpleNamespace(name="heat_at310"), rivals=(replace(at, follower=SPEED),))
    steps = (SimpleNamespace(added="heat_at310", tie=(), held_out=Error(0.1, 1.0)),)
    last = suggestion("nothing_missing")
    out = of_improvement(SimpleNamespace(kept=steps, last=last, uses=(), composed=(made,), model=other(1.0)), MODEL)
    assert out.composed == ["heat_at310"]
    assert (out.place_mm, out.follows, out.as_well) == (310.0, "speed2", ["speed"])
