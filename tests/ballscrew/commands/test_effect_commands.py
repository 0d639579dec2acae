"""The commands about effects: the catalogue, the battery on one's own, adding to a model, writing a new one."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from estimator.effects import CATALOGUE, HEAT, MOUNTING, READING, STRUCTURE
from estimator.inputs.follower import NAMES
from estimator.rig_folder.model_toml import load_model
from tests.conftest import PAPER
from tests.conftest import ballscrew as run

ROOT = Path(__file__).parents[3]
OWN = '''
from estimator.effect import Effect, Param
from estimator.effects.local import LocalHeat, spot
from estimator.terms import SCREW, Heat


class CoolantJet(Effect):
    """A jet of coolant cools one place while the pump [2] runs.

    q = -P around x = 350 mm
    """

    trace = "One place too cold."
    power = Param(5.0, "W", lo=-50.0, hi=50.0, null=0.0, source="a guess")

    def terms(self, p, u, rig):
        yield Heat(SCREW, -p.power, over=spot(rig, 350.0, 30.0))
'''
SECOND = '''

class Rubbing(Effect):
    """Something rubs.

    q = |P|
    """

    power = Param(5.0, "W", lo=-50.0, hi=50.0, null=0.0, source="a guess")

    def terms(self, p, u, rig):
        yield Heat(SCREW, abs(p.power), over=spot(rig, 500.0, 30.0))
'''


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """A working directory with a model and an effect file, far from any rig.toml."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "effects.py").write_text(OWN)
    shutil.copy(PAPER / "base.toml", tmp_path / "model.toml")
    return tmp_path


def done(*words: object) -> str:
    status, out, err = run(*words)
    assert status == 0, err
    return out


def refused(*words: object) -> str:
    """The one line with which a command refuses."""
    status, _, err = run(*words)
    assert status == 2
    (line,) = [line for line in err.splitlines() if not line.startswith("note: ")]
    assert line.startswith("error: ")
    return line.removeprefix("error: ")


# --- effects


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
    assert churning["scales"] == ["nut_friction"]
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
def test_an_effect_that_passes_ends_with_0(name, folder):
    out = done("effects", name, "--check")
    assert out.count("passes\n") + out.count("passes ") >= 8
    assert "FAILS" not in out
    assert "passes all checks on paper's ball screw" in out


def test_a_file_is_all_that_is_written_in_it(folder):
    out = done("effects", "effects.py")
    assert "coolant_jet" in out
    assert "while the pump [2] runs." in out
    assert "local_heat" not in out
    assert "local_heat" in done("effects", "effects.py:LocalHeat")


def test_an_effect_that_fails_ends_with_1_and_names_the_check(folder):
    (folder / "effects.py").write_text(OWN + SECOND)
    status, out, err = run("effects", "effects.py", "--check", "--json")
    assert status == 1
    assert "error: effects.py:Rubbing fails: derivative (power: the complex step of q of term 1 is not its slope" in err
    assert "coolant_jet" not in err.split("error:")[1]
    told = json.loads(out)
    assert [check["ok"] for check in told["coolant_jet"]["checks"]] == [True] * 8
    assert [check["check"] for check in told["rubbing"]["checks"] if not check["ok"]] == ["derivative"]


def test_the_rig_and_its_model_are_the_nearest_or_those_named(folder):
    rod = ROOT / "examples" / "heated_rod"
    out = done("effects", rod / "effects.py", "--check")
    assert out.count("passes all checks on heated rod") == 2
    status, out, err = run("effects", rod / "effects.py:Heater", "--check", "--rig", PAPER)
    assert status == 1
    assert "needs the input 'heater', which rig.toml has not in [inputs]" in err
    assert "has not in [inputs]" in " ".join(out.split())
    status, _, err = run("effects", "churning", "--check", "--rig", rod)
    assert status == 1
    assert "fits the rig (model.toml: churning: needs the effect 'nut_friction', which the model has not" in err


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["nut_fiction"], "no effect 'nut_fiction' in the catalogue; did you mean 'nut_friction'?"),
        (["none.py"], "none.py: no such effect file"),
        (["none.py:Jet"], "none.py: no such effect file"),
        (["effects.py:CoolantJett"], "effects.py has no effect 'CoolantJett'; did you mean 'CoolantJet'?"),
        (["--check"], "--check: of which effect? Name it: ballscrew effects NAME --check"),
        (["empty.py"], "empty.py: no effect in it; write a class that is an Effect, or ballscrew new-effect NAME"),
        (["torn.py"], "torn.py: SyntaxError: '(' was never closed (torn.py, line 1)"),
    ],
)
def test_an_effect_that_is_not_there_is_said_in_a_line(words, text, folder):
    (folder / "empty.py").write_text("from estimator.effects.local import LocalHeat\n")
    (folder / "torn.py").write_text("print(\n")
    assert refused("effects", *words) == text


def test_a_file_that_is_not_named_does_not_run(folder):
    (folder / "effects.py").write_text("raise SystemExit('ran')\n")
    done("effects")
    done("effects", "churning", "--check")
    done("add", "churning", "model.toml", "-o", "better.toml")
    assert refused("effects", "effects.py") == "effects.py: SystemExit: ran"


# --- add


def test_an_effect_of_the_catalogue_is_added_at_its_defaults(folder):
    before = (folder / "model.toml").read_bytes()
    out = done("add", "churning", "model.toml", "-o", "better.toml")
    assert "better.toml: churning added to 13 effects, at its defaults" in out
    old, new = load_model(folder / "model.toml"), load_model(folder / "better.toml")
    assert new.effects.keys() - old.effects.keys() == {"churning"}
    assert {path: new.values[path] for path in old.values} == dict(old.values)
    assert new["churning.share"] == CATALOGUE["churning"].params["share"].value
    assert new.about == old.about
    assert (folder / "model.toml").read_bytes() == before


def test_what_nobody_has_fitted_is_as_uncertain_as_its_source_says(folder):
    done("add", "held_ends", "model.toml", "-o", "better.toml")
    model = load_model(folder / "better.toml")
    assert {key: model.values[f"held_ends.{key}"].sd for key in ("k_anchor", "k_free", "E")} == {
        "k_anchor": 400.0, "k_free": 400.0, "E": None,
    }  # fmt: skip
    assert {*model.doubts.paths} - {*load_model(folder / "model.toml").doubts.paths} == {
        "held_ends.k_anchor", "held_ends.k_free",
    }  # fmt: skip


def test_an_effect_of_ones_own_is_kept_as_seen_from_the_new_model(folder):
    (folder / "deep" / "er").mkdir(parents=True)
    done("add", "effects.py:CoolantJet", "model.toml", "-o", "deep/er/m.toml")
    assert 'use = "../../effects.py:CoolantJet"' in (folder / "deep/er/m.toml").read_text()
    done("add", "effects.py", "model.toml", "-o", "model.toml")
    assert load_model(folder / "model.toml").use == {"coolant_jet": "effects.py:CoolantJet"}
    done("add", "churning", "deep/er/m.toml", "-o", "both.toml")
    assert load_model(folder / "both.toml").use == {"coolant_jet": "effects.py:CoolantJet"}
    told = json.loads(done("add", "radiation", "both.toml", "-o", "both.toml", "--json"))
    assert told["effect"] == "radiation"
    assert told["parameters"] == {"emissivity": 0.5}


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (
            ["nut_body", "model.toml", "-o", "x.toml"],
            "model.toml has the effect 'nut_body' already; change its values in the file, or fit them",
        ),
        (["curning", "model.toml", "-o", "x.toml"], "no effect 'curning' in the catalogue; did you mean 'churning'?"),
        (
            ["churning", "bare.toml", "-o", "x.toml"],
            "bare.toml: churning: needs the effect 'nut_friction', which the model has not; add it first",
        ),
        (["churning", "none.toml", "-o", "x.toml"], "none.toml: no such file"),
        (["churning", "model.toml", "-o", "none/x.toml"], "none/x.toml: there is no folder none"),
        (
            ["two.py", "model.toml", "-o", "x.toml"],
            "two.py has 2 effects; name one of them: two.py:CoolantJet, two.py:Rubbing",
        ),
    ],
)
def test_what_cannot_be_added_is_said_in_a_line(words, text, folder):
    (folder / "bare.toml").write_text("[conduction]\n[still_air]\n[thermometers]\n")
    (folder / "two.py").write_text(OWN + SECOND)
    assert refused("add", *words).startswith(text)
    assert not (folder / "x.toml").exists()


def test_an_effect_that_could_do_more_says_what_it_lacks(folder):
    (folder / "bare.toml").write_text("[conduction]\n[nut_friction]\n[thermometers]\n")
    status, _, err = run("add", "friction_thinning", "bare.toml", "-o", "x.toml")
    assert status == 0
    assert "note: friction_thinning acts on nut_body, anchor_friction, anchor_housing, free_friction, free_hous" in err


# --- new-effect


READINGS = [None, "all", "T04", "displacement"]


def test_every_follower_and_reading_makes_an_effect_that_passes_as_written(folder):
    """Each follower everywhere or at a place, and with one of the readings, in turn."""
    (folder / "effects.py").unlink()
    rig_inputs = [*NAMES, "board", "ambient", "position"]
    made = []
    for i, follows in enumerate(rig_inputs):
        turn = READINGS[i % 3 + 1]
        for k, reading in enumerate((None, turn) if follows != "temperature_speed" else (None,)):
            words = ["--reading", reading] if reading else []
            name, at = f"effect {chr(97 + i)}{chr(97 + k)}", ["--at", "350mm"] if i % 2 and not reading else []
            out = done("new-effect", name, "--follows", follows, *words, *at)
            made.append(name)
            assert "effects.py: Effect" in out
    status, out, err = run("effects", "effects.py", "--check", "--json")
    assert status == 0, err
    told = json.loads(out)
    assert len(told) == len(made) == 2 * len(rig_inputs) - 1
    assert {check["detail"] for one in told.values() for check in one["checks"]} == {""}
    assert all(one["trace"].endswith(".") for one in told.values())
    ruff = [
        Path(sys.executable).with_name("ruff"),
        "check",
        "--select",
        "E,F,B,UP",
        "--line-length",
        "120",
        "effects.py",
    ]
    assert subprocess.run(ruff, check=False).returncode == 0
    formatted = [ruff[0], "format", "--check", "--line-length", "120", "effects.py"]
    assert subprocess.run(formatted, check=False).returncode == 0


def test_what_is_printed_next_works(folder):
    (folder / "effects.py").unlink()
    out = done("new-effect", "oil-bath", "--at", "350 mm", "--follows", "early_stop")
    commands = [line.partition("ballscrew ")[2].split() for line in out.splitlines() if "ballscrew " in line]
    commands = [words for words in commands if words[0] in ("effects", "add")]
    assert commands == [
        ["effects", "effects.py:OilBath", "--check"],
        ["add", "effects.py:OilBath", "model.toml", "-o", "better.toml"],
    ]
    for words in commands:
        done(*words)
    model = load_model(folder / "better.toml")
    assert (model["oil_bath.at"], model.param("oil_bath.power").null) == (350.0, 0.0)


def test_a_new_effect_is_put_behind_what_is_there_without_running_it(folder):
    text = OWN + "\n\nassert not __name__, 'ran'  # the file's own last line\n"
    (folder / "effects.py").write_text(text)
    done("new-effect", "hot_rod", "--reading", "T04", "--follows", "temperature")
    new = (folder / "effects.py").read_text()
    head, _, rest = new.partition("\nclass CoolantJet")
    assert "from estimator.terms import SCREW, START, Heat, Read, Spot\n" in head
    assert rest.startswith(text.partition("\nclass CoolantJet")[2].rstrip())
    assert refused("new-effect", "hot_rod") == (
        "effects.py: 'HotRod' is there already; choose another name, or another file with -o"
    )
    assert (folder / "effects.py").read_text() == new


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["4711"], "'4711' cannot be an effect's name; take words of letters, such as coolant_jet"),
        (["heat"], "'heat' cannot be an effect's name; take words of letters, such as coolant_jet"),
        (["churning"], "the catalogue has an effect 'churning' already; choose another name"),
        (["jet", "--at", "here"], "--at here: write a place in mm, such as 350mm"),
        (["jet", "--at", "2000mm"], "--at 2000mm: outside the screw, -50 ... 1030 mm"),
        (["jet", "--at", "35mm", "--reading", "T04"], "--at is where heat goes, --reading shifts a reading: leave one"),
        (
            ["jet", "--follows", "bord"],
            "--follows bord: neither known nor an input of paper's ball screw; did you mean",
        ),
        (
            ["jet", "--reading", "displacment"],
            "--reading displacment: paper's ball screw has no such channel; did you mean",
        ),
        (["jet", "-o", "torn.py"], "torn.py: line 1 is not Python: '(' was never closed; correct it first"),
        (["jet", "-o", "none/x.py"], "none/x.py: there is no folder none"),
    ],
)
def test_what_cannot_be_written_is_said_in_a_line(words, text, folder):
    (folder / "torn.py").write_text("print(\n")
    before = (folder / "effects.py").read_text()
    assert refused("new-effect", *words).startswith(text)
    assert (folder / "effects.py").read_text() == before


def test_a_word_of_the_vocabulary_that_means_something_else_in_the_file(folder):
    (folder / "effects.py").write_text("def spot(rig, at, width):\n    return 1.0\n")
    assert refused("new-effect", "jet", "--at", "350mm").startswith("effects.py: 'spot' is there already; ")
    done("new-effect", "jet")


@pytest.mark.parametrize(
    ("head", "line"),
    [
        ("", "from estimator.effect import Effect, Param"),
        ('"""Mine."""\n', "from estimator.effect import Effect, Param"),
        ("import numpy as np\n\nX = 1\n", "from estimator.effect import Effect, Param"),
        ("from estimator.effect import (\n    Effect,\n)\n", "from estimator.effect import Param"),
        ("from estimator.terms import Heat  # mine\n", "from estimator.terms import SCREW"),
    ],
)
def test_imports_go_where_imports_are(head, line, folder):
    (folder / "effects.py").write_text(head)
    done("new-effect", "jet", "--follows", "early_stop")
    assert line in (folder / "effects.py").read_text().splitlines()
    done("effects", "effects.py", "--check")
