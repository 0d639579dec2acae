"""Rigs that are no ball screw: the commands that look for what is missing, on a heated rod and on two heaters."""

import importlib.util
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from estimator.missing_effect.wrong_input import signals
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from tests.conftest import ROD, TWO, ballscrew, ended, json_of as told


def copied(rig: Path, to: Path, *but: str, rows: int | None = None) -> Path:
    """A rig folder without some of its files, of each recording the first rows."""
    shutil.copytree(rig, to, ignore=shutil.ignore_patterns("__pycache__", *but))
    for path in to.glob("*.csv"):
        path.write_text("\n".join([*path.read_text().splitlines()[:rows], ""]))
    return to


def without(rig: Path, name: str) -> None:
    """Take an effect out of a folder's model."""
    text = (rig / "model.toml").read_text()
    assert f"[{name}]" in text
    (rig / "model.toml").write_text(re.sub(rf"\[{name}\].*?(?=\n\[|\Z)", "", text, flags=re.DOTALL))


def columns(path: Path, change: dict[str, float]) -> None:
    """Multiply columns of a CSV."""
    head, *rows = path.read_text().splitlines()
    names = head.split(",")
    for i, row in enumerate(rows):
        cells = row.split(",")
        for name, ratio in change.items():
            cells[names.index(name)] = f"{float(cells[names.index(name)]) * ratio:.5g}"
        rows[i] = ",".join(cells)
    path.write_text("\n".join([head, *rows, ""]))


@pytest.fixture(scope="module")
def coupled(tmp_path_factory) -> Path:
    """The folder of the two heaters with the model that `improve` makes."""
    folder = copied(TWO, tmp_path_factory.mktemp("two") / "rig", "first.csv")
    out = folder / "better.toml"
    found = told("improve", folder, "-o", out, "--held-out", folder / "steps.csv")
    assert [step["added"] for step in found["steps"]] == [None, "coupling"]
    assert found["steps"][1]["held_out"]["temperature_K"] < 0.08
    assert found["verdict"] == "nothing_missing"
    shutil.move(out, folder / "model.toml")
    return folder


# --- two heaters


@pytest.fixture(scope="module")
def script():
    """What makes the runs of the two heaters."""
    spec = importlib.util.spec_from_file_location("make_runs", TWO / "make_runs.py")
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def test_the_runs_of_the_two_heaters_are_those_of_their_script(script):
    there = np.loadtxt(TWO / "first.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(script.lived(*script.RUNS["first.csv"], 0), there, atol=0.006)


def test_what_it_lacks_follows_the_other_heater():
    found = told("diagnose", TWO)
    assert not found["adequate"]
    assert {(each["node"], each["follows"]) for each in found["where"]} == {
        ("body_1", "heater_2"),
        ("body_2", "heater_1"),
    }
    assert all(
        each["heat_W"] > 10.0 * each["sd_W"] for each in found["where"]
    )  # constant for no longer than they forget
    assert not any("rest" in sentence or "stop" in sentence for sentence in found["sentences"])


def test_with_the_coupling_nothing_is_missing(coupled):
    assert load_model(coupled / "model.toml")["coupling.g"] == pytest.approx(0.0228, rel=0.05)
    assert told("diagnose", coupled)["adequate"]
    out, _ = ended(0, "compare", coupled)
    assert "nan" not in out


def test_a_lag_of_which_no_thermometer_has_any_is_found_beside_the_coupling(tmp_path):
    """Three minutes each of two runs prove both together, and neither alone."""
    rig = copied(TWO, tmp_path / "rig", "second.csv", "steps.csv", rows=50)
    without(rig, "sensor_lag")
    found = told("improve", rig, "-o", rig / "better.toml", "--report", rig / "better.md")
    assert [step["added"] for step in found["steps"]] == [None, "coupling + sensor_lag"]
    report = (rig / "better.md").read_text()
    assert "warm each other through the board" in report
    assert "more slowly" in report


def test_since_healthy_recordings_nothing_has_changed(coupled):
    found = told("suggest", coupled / "both.csv", "--healthy", coupled / "steps.csv")
    assert found["verdict"] == "nothing_missing"


def test_a_wrong_heater_names_run_and_signal(coupled, tmp_path):
    wrong = copied(coupled, tmp_path / "rig")
    columns(wrong / "steps.csv", {"heater_2": 1.1})
    found = told("suggest", wrong)
    assert found["verdict"] == "input_error"
    assert (found["input"]["run"], found["input"]["signal"]) == ("steps.csv", "heater_2")
    assert found["input"]["ratio"] == pytest.approx(1.1, abs=0.03)
    assert found["sentence"].startswith("Nothing is missing, but in steps.csv ")


def test_an_effect_in_no_file_is_a_body_and_an_input_and_can_be_begun(tmp_path, monkeypatch):
    rig = copied(TWO, tmp_path / "rig", "first.csv")
    text = (rig / "effects.py").read_text()
    (rig / "effects.py").write_text(re.sub(r"class Coupling.*?(?=\nclass )", "", text, flags=re.DOTALL))
    before = (rig / "effects.py").read_text()
    by_one, found = (told("suggest", runs, "--compose", rig / "effects.py") for runs in (rig / "both.csv", rig))
    assert {found["verdict"], by_one["verdict"]} == {"nothing_in_catalogue"}
    assert (found["where"]["node"], found["where"]["follows"]) in {("body_1", "heater_2"), ("body_2", "heater_1")}
    assert by_one["composed"] is None
    assert (rig / "effects.py").read_text() == f"{before}\n\n{found['composed']['text']}"
    line = by_one["sentence"].partition("ballscrew ")[2].split()
    monkeypatch.chdir(rig)
    for words in (
        ["effects", "effects.py", "--check"],
        line,
        ["effects", "effects.py:MyReading", "--check"],
        ["add", "effects.py:MyReading", "model.toml", "-o", "m"],
    ):
        ended(0, *words)


def test_one_recording_names_another_and_with_it_something_can_be_left_out(script, tmp_path):
    status, out, _ = ballscrew("suggest", TWO / "both.csv", "--json", tmp_path / "found.json")
    found = json.loads((tmp_path / "found.json").read_text())
    assert status == 0
    assert (found["verdict"], found["effects"][0]["name"]) == ("effect", "coupling")
    names = {each["name"] for each in found["effects"]}
    assert not names & {"expansion_error", "channel_offset"}  # no length is read, and nothing ever moves
    assert "make another" in found["sentence"]
    assert "left out once" not in out
    run = found["next_run"]
    assert (run["pattern"], run["speed_m_min"], run["why"]) == ("step", None, "one recording")
    assert run["between"] == ["coupling", "the model alone"]
    assert run["separation_sd"] > 10
    (heater, level), on = next(iter(run["levels"].items())), f"{run['drive_s'] / 60:.0f} min on"
    assert f"A run with {heater} at {level:g} %, {on}" in found["sentence"]

    rig = copied(TWO, tmp_path / "rig")
    steps = {heater: [(60, 60 + run["drive_s"], level)]}
    rows = script.lived(steps.get("heater_1", []), steps.get("heater_2", []), 5)
    np.savetxt(rig / "next.csv", rows, "%.5g", ",", header="t_s,heater_1,heater_2,T1,T2,air_C", comments="")
    again = told("suggest", rig / "both.csv", rig / "next.csv")
    assert (again["verdict"], again["effects"][0]["name"]) == ("effect", "coupling")
    assert "make another" not in again["sentence"]
    assert again["next_run"] is None


def test_a_model_far_off_that_nothing_explains_is_not_complete(coupled, tmp_path):
    """Sensors swapped in every run but one: no effect and no input does that."""
    rig = copied(coupled, tmp_path / "rig")
    for name in ("both.csv", "steps.csv"):
        text = (rig / name).read_text()
        (rig / name).write_text(text.replace("T1,T2", "T2,T1"))
    found = told("suggest", rig)
    assert found["verdict"] != "nothing_missing"
    assert "Nothing is missing" not in found["sentence"]


def test_what_is_held_out_is_not_used_from_its_folder_and_an_own_effect_that_does_not_fit_is_left_out(tmp_path):
    rig = copied(TWO, tmp_path / "rig", "first.csv", "second.csv")
    words = ["--held-out", rig / "steps.csv", "--effects", ROD / "effects.py:Heater"]
    out, err = ended(0, "suggest", rig, *words)
    assert "held out, and so not used: steps.csv" in out
    assert "Heater is not tried: heater: AttributeError" in err
    assert "coupling is missing" in out


def test_gaps_and_a_slow_tick(tmp_path):
    rig = copied(TWO, tmp_path / "rig", "first.csv", "second.csv")
    (rig / "rig.toml").write_text((rig / "rig.toml").read_text().replace("tick_s = 4.0", "tick_s = 60.0"))
    dice = np.random.default_rng(1)
    for path in rig.glob("*.csv"):
        head, *rows = path.read_text().splitlines()
        cells = [row.split(",") for row in rows[::5]]
        for row in cells[1:]:
            for i in np.flatnonzero(dice.random(len(row)) < 0.2):
                row[i] = row[i] if i == 0 else ""
        path.write_text("\n".join([head, *map(",".join, cells), ""]))
    found = told("suggest", rig)
    assert (found["verdict"], found["effects"][0]["name"]) == ("effect", "coupling")
    out, _ = ended(0, "diagnose", rig)
    assert "nan" not in out


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([], "two heaters has no screw; say with --at which body is heated: body_1, body_2"),
        (["--at", "30mm"], "--at 30mm: two heaters has no screw, and no thermometer in such a body"),
        (["--at", "body_1", "--follows", "drive"], "--follows drive: two heaters has no input 'speed'"),
    ],
)
def test_an_effect_that_cannot_be_here_is_refused_in_one_line(tmp_path, words, says):
    _, err = ended(2, "new-effect", "jet", *words, "--rig", TWO, "-o", tmp_path / "effects.py")
    assert err.startswith(f"error: {says}")
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("follows", ["always", "time", "temperature", "heater_2", "ambient"])
def test_a_new_effect_of_a_body_passes_as_written(tmp_path, follows):
    file = tmp_path / "effects.py"
    assert ballscrew("new-effect", "jet", "--at", "body_2", "--follows", follows, "--rig", TWO, "-o", file)[0] == 0
    out, _ = ended(0, "effects", file, "--check", "--rig", TWO)
    assert "effects.py:Jet passes all checks on two heaters" in out


# --- a heated rod


def test_what_the_rod_s_model_lacks_is_found(tmp_path):
    name, rig = "chilled_end", copied(ROD, tmp_path / "rig", "check.csv", "slow.csv", "pulses.csv", rows=500)
    without(rig, name)
    found = told("suggest", rig, "--effects", rig / "effects.py")
    assert (found["verdict"], found["effects"][0]["name"]) == ("effect", name)
    assert found["effects"][0]["after"]["temperature_K"] < 0.06


def test_nothing_is_missing_from_the_rod(tmp_path):
    rig = copied(ROD, tmp_path / "rig", "pulses.csv", "slow.csv", rows=500)
    assert told("suggest", rig)["verdict"] == "nothing_missing"
    assert told("diagnose", rig)["adequate"]


def test_every_temperature_that_heat_flows_to_may_be_wrong():
    rig = load_rig(ROD)
    assert set(signals(load_model(ROD / "model.toml"), rig)) == {"ambient", "chiller", "heater"}
