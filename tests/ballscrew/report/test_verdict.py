"""Verdicts of a search in words."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from ballscrew.report.search.verdict import _beside, _sentence, seated, thermometer_of
from estimator.missing_effect.suggestion import Suggestion
from estimator.model import Value

N = "nut_friction.n"


@pytest.mark.parametrize("verdict", ["effect", "nothing_in_catalogue"])
def test_what_was_held_fixed_and_is_another_is_told_beside_an_effect(verdict, full):
    was, here = (full.with_values({N: replace(full.values[N], value=v, sd=0.008)}) for v in (1.0, 1.103))
    found, given = SimpleNamespace(known=lambda: here), SimpleNamespace(ground=SimpleNamespace(model=was))
    said = _beside(SimpleNamespace(verdict=verdict, found=[found], loosened=[N], as_given=given))
    told = "Held fixed in the model, but nut_friction.n is 1.103 +- 0.008 here, not 1."
    assert said == (told if verdict == "effect" else "")


@pytest.mark.parametrize(
    ("verdict", "tie", "pair", "misfit", "second", "said"),
    [
        ("effect", (), ("churning", "motor_heat"), 2.0, "motor_heat", "A second one besides: motor_heat."),
        ("effect", (), (), 1.0, "", "on recordings left out."),
        ("effect", (), (), 2.0, "", "adds it and looks for more."),
        ("tie", ("churning", "radiation"), ("radiation", "motor_heat"), 1.0, "motor_heat", "besides: motor_heat."),
        ("effects", (), ("churning", "motor_heat"), 2.0, "", "on recordings left out."),
    ],
)
def test_a_second_effect_is_told_beside_the_one_that_is_named_or_its_rivals(
    verdict, tie, pair, misfit, second, said, every
):
    judged = SimpleNamespace(error=SimpleNamespace(temperature_K=0.1, elongation_um=0.5), runs=[0.0, 0.0])
    h = SimpleNamespace(
        names=pair if verdict == "effects" else ("churning",), judged=judged, refit=False, misfit=misfit, model=every
    )
    found = Suggestion(verdict, (h,), tie, h, h, h, (), pair=pair)
    assert found.second == second
    assert _sentence(SimpleNamespace(suggestion=found), None).endswith(said)


@pytest.mark.parametrize(
    ("name", "at", "said"),
    [
        ("channel_gain", {"channel_gain.channel": 6.0}, "channel_gain of T06"),
        ("local_heat", {"local_heat.at": 348.6}, "local_heat at 349 mm"),
        ("churning", {}, "churning"),
    ],
)
def test_an_effect_that_may_sit_in_many_places_is_named_with_its_own(name, at, said, every, rig):
    assert seated(SimpleNamespace(names=(name,), model=every.with_values(at)), rig) == said


def test_two_effects_of_a_thermometer_each_are_about_none(every, rig):
    assert thermometer_of(SimpleNamespace(names=("channel_gain", "channel_offset"), model=every), rig) == ""


@pytest.mark.parametrize(
    ("partly", "said"),
    [
        ("", "no effect that was tried explains it, nor"),
        ("churning", "no effect that was tried explains most of it (churning takes 20% off the misfit), nor"),
    ],
)
def test_what_explains_a_part_is_named_as_that(partly, said):
    judged = SimpleNamespace(error=SimpleNamespace(temperature_K=0.1, elongation_um=0.5), runs=[0.0, 0.0])
    before, h = (SimpleNamespace(names=("churning",), judged=judged, refit=False, misfit=m) for m in (10.0, 8.0))
    found = Suggestion("nothing_in_catalogue", (h,), (), before, before, before, (), far=True, partly=partly)
    assert said in _sentence(SimpleNamespace(suggestion=found), None)


@pytest.mark.parametrize(("misfit", "said"), [(0.6, "Nothing is missing: "), (3.0, "Nothing is proven: ")])
def test_a_model_that_leaves_much_is_not_said_to_lack_nothing(misfit, said):
    judged = SimpleNamespace(error=SimpleNamespace(temperature_K=0.21, elongation_um=0.5), runs=[0.0, 0.0])
    before = SimpleNamespace(names=(), judged=judged, refit=False, misfit=misfit)
    found = Suggestion("nothing_missing", (), (), before, before, before, ())
    assert _sentence(SimpleNamespace(suggestion=found), None).startswith(said)


@pytest.mark.parametrize(
    ("misfit", "head", "end"),
    [(0.6, "missing", "on recordings left out."), (3.0, "proven", "left out, more than a good model.")],
)
def test_nor_is_one_that_leaves_much_with_a_parameter_of_another_value(misfit, head, end, every):
    judged = SimpleNamespace(error=SimpleNamespace(temperature_K=0.21, elongation_um=0.5), runs=[0.0, 0.0])
    path, ground = "nut_friction.power", SimpleNamespace(model=every)
    before = SimpleNamespace(judged=judged, misfit=4.0, ground=ground)
    h = SimpleNamespace(judged=judged, misfit=misfit, model=every, own=lambda: {path: Value(72.0, 2.0)})
    said = _sentence(
        SimpleNamespace(suggestion=Suggestion("nothing_missing", (h,), (), before, before, before, (), path)), None
    )
    assert said.startswith(f"Nothing is {head}, but {path} is 72 +- 2 W here, not ")
    assert said.endswith(end)
