"""Review and compare say in one line whose machine a model is not, and which command comes next."""

import json
import re
import shlex
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from ballscrew.machine import MachineVerdict
from ballscrew.terminal import Terminal
from ballscrew.workspace import Loaded, Workspace
from estimator.accuracy.machine import Match
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from tests.conftest import ROD, ballscrew as run

CHECK = ROD / "check.csv"


@pytest.fixture(scope="module")
def another(tmp_path_factory) -> Path:
    """The rod's model, as if its heater gave a tenth less."""
    path = tmp_path_factory.mktemp("another rod") / "model.toml"
    text = (ROD / "model.toml").read_text().replace('"effects.py', f'"{ROD}/effects.py')
    path.write_text(re.sub(r"share = {value = [0-9.]+", "share = {value = 0.855", text))
    return path


def test_of_its_own_machine_nothing_is_said():
    told = json.loads(run("review", CHECK, "--json", "--quiet")[1])["machine"]
    assert (told["own"], told["sentence"], told["next"]) == (True, None, None)
    assert told["recordings"][0]["off_sd"] < 1.0


def test_review_and_compare_say_whose_it_is_not_and_what_to_do(another, tmp_path):
    said = []
    for command in ("review", "compare"):
        status, out, _ = run(command, CHECK, "--rig", ROD, "--model", another, "--json", tmp_path / "told.json")
        told = json.loads((tmp_path / "told.json").read_text())
        said.append(told["machine"] if command == "review" else told["models"][0]["machine"])
        assert status == 0
        assert out.count("model.toml is not this machine's: alone it is ") == 1
        assert said[-1]["sentence"] in out
    assert said[0] == said[1]
    expected = ["ballscrew", "fit", CHECK, "--rig", ROD, "--model", another, "-o", "fitted.toml"]
    assert shlex.split(said[0]["next"]) == [str(word) for word in expected]


def test_what_was_fitted_to_is_to_be_diagnosed_and_one_of_many_by_itself():
    model = load_model(ROD / "model.toml")
    prints = {"steps.csv": model.about["fitted_on"]["steps.csv"], "slow.csv": "another"}
    loaded = [Loaded(ROD / name, SimpleNamespace(fingerprint=mark)) for name, mark in prints.items()]
    work = Workspace(Terminal(quiet=True), load_rig(ROD), model, [ROD])
    fitted = MachineVerdict(work, model, Match([9.0]), loaded[:1])
    assert fitted.next == f"ballscrew diagnose {ROD} --model {ROD / 'model.toml'}"
    assert "lacks something: fitted to these recordings, alone it is 9.0 times" in fitted.sentence
    about = {**model.about, "covariance": {"paths": model.free()[1:], "correlation": []}}
    grown = MachineVerdict(work, replace(model, about=about), Match([9.0]), loaded[:1])
    assert grown.next == f"ballscrew fit {ROD} --model {ROD / 'model.toml'} -o fitted.toml"
    assert f"is not fitted since {model.free()[0].split('.')[0]} came in: alone it is 9.0 times" in grown.sentence
    odd = MachineVerdict(work, model, Match([1.0, 9.0]), loaded)
    assert odd.next == f"ballscrew diagnose {ROD / 'slow.csv'} --model {ROD / 'model.toml'}"
    assert "does not follow slow.csv, but the others" in odd.sentence
