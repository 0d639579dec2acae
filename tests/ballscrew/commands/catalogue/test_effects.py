"""`ballscrew effects`: the catalogue, and the battery on one's own."""

import json

import pytest

from estimator.effects import CATALOGUE, HEAT, MOUNTING, READING, STRUCTURE
from tests.ballscrew.commands.conftest import OWN, SECOND, done, refused
from tests.conftest import PAPER, ROOT, ended


def test_the_catalogue_is_printed_by_kind():
    out = done("effects")
    for kind, effects in (("structure", STRUCTURE), ("mounting", MOUNTING), ("heat", HEAT), ("reading", READING)):
        assert f"\n{kind}" in f"\n{out}"
        part = f"\n{out}".split(f"\n{kind}")[1]
        assert all(f"\n{effect.name} " in part for effect in effects)
    assert " ".join(CATALOGUE["churning"].sentence().split()) in " ".join(out.split())


def test_the_catalogue_as_json():
    told = json.loads(done("effects", "--json"))
    assert list(told) == ["structure", "mounting", "heat", "reading"]
    assert {name for kind in told.values() for name in kind} == set(CATALOGUE)
    churning = told["heat"]["churning"]
    assert churning["trace"] == CATALOGUE["churning"].trace
    assert churning["scales"] == ["nut_friction", "nut_balls"]
    share = churning["parameters"]["share"]
    assert (share["value"], share["lo"], share["hi"], share["null"], share["unit"]) == (0.4, -0.5, 3.0, 0.0, "1")


def test_one_effect_in_full():
    out = done("effects", "local_heat")
    assert CATALOGUE["local_heat"].sentence() in out
    assert "q = P around the place `at`" in out
    assert CATALOGUE["local_heat"].trace in out
    power = next(line for line in out.splitlines() if line.strip().startswith("power"))
    assert all(word in power for word in ("1.5", "W", "-500 ... 500", "0", "a chip pile"))
    ratio = next(line for line in done("effects", "friction_thinning").splitlines() if line.strip().startswith("ratio"))
    assert "fixed" in ratio


@pytest.mark.parametrize("name", ["churning", "effects.py:CoolantJet", "effects.py"])
def test_an_effect_that_passes_ends_with_0(name, own_effects):
    out = done("effects", name, "--check")
    assert out.count("passes\n") + out.count("passes ") >= 8
    assert "FAILS" not in out
    assert "passes all checks on paper's ball screw" in out


def test_a_file_is_all_that_is_written_in_it(own_effects):
    out = done("effects", "effects.py")
    assert "coolant_jet" in out
    assert "while the pump [2] runs." in out
    assert "local_heat" not in out
    assert "local_heat" in done("effects", "effects.py:LocalHeat")


def test_an_effect_that_fails_ends_with_1_and_names_the_check(own_effects):
    (own_effects / "effects.py").write_text(OWN + SECOND)
    out, err = ended(1, "effects", "effects.py", "--check", "--json")
    assert "error: effects.py:Rubbing fails: derivative (power: the complex step of q of term 1 is not its slope" in err
    assert "coolant_jet" not in err.split("error:")[1]
    told = json.loads(out)
    assert [check["ok"] for check in told["coolant_jet"]["checks"]] == [True] * 8
    assert [check["check"] for check in told["rubbing"]["checks"] if not check["ok"]] == ["derivative"]


def test_the_rig_and_its_model_are_the_nearest_or_those_named(own_effects):
    rod = ROOT / "examples" / "heated_rod"
    out = done("effects", rod / "effects.py", "--check")
    assert out.count("passes all checks on heated rod") == 2
    out, err = ended(1, "effects", rod / "effects.py:Heater", "--check", "--rig", PAPER)
    assert "needs the input 'heater', which rig.toml has not in [inputs]" in err
    assert "has not in [inputs]" in " ".join(out.split())
    _, err = ended(1, "effects", "churning", "--check", "--rig", rod)
    assert "fits the rig (model.toml: churning: needs the effect 'nut_friction', which the model has not" in err


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ("nut_fiction", "no effect 'nut_fiction' in the catalogue; did you mean 'nut_friction'?"),
        ("none.py", "none.py: no such effect file"),
        ("none.py:Jet", "none.py: no such effect file"),
        ("effects.py:CoolantJett", "effects.py has no effect 'CoolantJett'; did you mean 'CoolantJet'?"),
        ("--check", "--check: of which effect? Name it: ballscrew effects NAME --check"),
        ("empty.py", "empty.py: no effect in it; write a class that is an Effect, or ballscrew new-effect NAME"),
        ("torn.py", "torn.py: SyntaxError: '(' was never closed (torn.py, line 1)"),
    ],
)
def test_an_effect_that_is_not_there_is_said_in_a_line(words, text, own_effects):
    (own_effects / "empty.py").write_text("from estimator.effects.local import LocalHeat\n")
    (own_effects / "torn.py").write_text("print(\n")
    assert refused("effects", *words.split()) == text


def test_a_file_that_is_not_named_does_not_run(own_effects):
    (own_effects / "effects.py").write_text("raise SystemExit('ran')\n")
    done("effects")
    done("effects", "churning", "--check")
    done("add", "churning", "model.toml", "-o", "better.toml")
    assert refused("effects", "effects.py") == "effects.py: SystemExit: ran"
