"""What a command works on: rig folders, models, recordings."""

import json
import re
import shutil
from unittest import mock

import pytest

from estimator.rig_folder.model_toml import load_model, save_model
from tests import log_fake
from tests.conftest import PAPER, ROD, ROOT, ballscrew as run, ended, json_of


def test_without_a_rig_file_above_the_built_in_rig_is_used_and_named(short_log):
    out, _ = ended(0, "review", short_log)
    assert "no rig.toml at or above" in out
    assert "using the built-in rig, the paper's ball screw" in out


def test_what_comes_after_a_long_gap_is_judged_from_a_start_of_its_own(tmp_path):
    shutil.copytree(ROD, tmp_path / "rod")
    log = tmp_path / "rod" / "check.csv"
    head, *rows = log.read_text().splitlines()
    log.write_text("\n".join([head, *rows[:300], *rows[540:]]))  # the heater is switched off meanwhile
    out, err = ended(0, "diagnose", log, "--json", said := tmp_path / "said.json")
    assert (
        "check.csv: nothing was read for long; used from 0 to 1495 s and 2700 to 3895 s, from a start of" in out + err
    )
    assert json.loads(said.read_text())["adequate"]
    out, _ = ended(0, "review", log, "--json", said)
    assert "check.csv: nothing was read from 1495 to 2700 s: what the machine did then is not known" in out
    (review,) = json.loads(said.read_text())["recordings"]
    assert review["nis_mean"] < 1.5


@pytest.mark.parametrize("option", ["--json", "--save"])
def test_an_output_that_cannot_be_written_is_told_before_the_work(option, short_folder):
    (blocked := short_folder / "out.json").mkdir()
    with mock.patch("ballscrew.workspace.load", side_effect=AssertionError("work was begun")):
        status, _, err = run("review", short_folder / "logs", option, blocked)
    assert status == 2
    assert f"error: {blocked}: cannot be written: is a directory" in err


def test_asking_whether_an_output_can_be_written_changes_nothing(short_folder):
    kept = short_folder / "kept.json"
    kept.write_text("{}")
    assert run("review", short_folder / "none.log", "--json", kept)[0] == 1
    assert run("review", short_folder / "none.log", "--json", short_folder / "new.json")[0] == 1
    assert kept.read_text() == "{}"
    assert not (short_folder / "new.json").exists()


@pytest.mark.parametrize("text", ["", "[conduction]\n", "[still_air]\n[conduction]\n"])
def test_a_model_that_reads_no_thermometer_is_refused(text, short_folder):
    (short_folder / "model.toml").write_text(text)
    _, err = ended(2, "review", short_folder / "logs")
    assert "model.toml: no effect reads a thermometer; add [thermometers]" in err


def test_a_recording_without_a_temperature_is_told_and_the_others_are_reviewed(tmp_path):
    shutil.copytree(ROD, tmp_path / "rod")
    rod = tmp_path / "rod"
    good = next(path for path in rod.rglob("*.csv"))
    head, *rows = good.read_text().splitlines()
    names = head.split(",")
    kept = [i for i, name in enumerate(names) if not name.startswith("TC")]
    blank = [",".join(cell if i in kept else "" for i, cell in enumerate(row.split(","))) for row in rows]
    (rod / "blind.csv").write_text("\n".join([head, *blank, ""]))
    out, err = ended(1, "review", rod / "blind.csv", good)
    assert "error: blind.csv: no thermometer was ever read; nothing to estimate from" in err
    assert good.name in out
    assert run("review", rod / "blind.csv")[0] == 1


def test_an_input_that_was_never_read_is_said_first(tmp_path):
    shutil.copytree(ROD, tmp_path / "rod")
    log = tmp_path / "rod" / "steps.csv"
    head, *rows = log.read_text().splitlines()
    heater = head.split(",").index("heater_W")
    cells = [row.split(",") for row in rows[:60]]
    log.write_text("\n".join([head, *(",".join([*row[:heater], "", *row[heater + 1 :]]) for row in cells), ""]))
    out, _ = ended(0, "review", log)
    told = [line for line in out.splitlines() if line.startswith("steps.csv: ")]
    doing = "if it was not 0, thermometers may be accused of what it does"
    assert told[1] == f"steps.csv: input heater was never read: 0 stands for it; {doing}"
    assert json_of("review", log)["recordings"][0]["inputs_never_read"] == ["heater"]


def test_a_copy_of_a_recording_is_no_other_witness(tmp_path):
    shutil.copytree(ROD, tmp_path / "rod")
    log = tmp_path / "rod" / "steps.csv"
    log.write_text("".join(log.read_text().splitlines(keepends=True)[:200]))
    shutil.copy(log, tmp_path / "rod" / "copy.csv")
    out, err = ended(0, "suggest", log, tmp_path / "rod" / "copy.csv", "--json")
    assert "copy.csv is steps.csv once more: used once" in err
    assert [one["name"] for one in json.loads(out)["recordings"]] == ["steps.csv"]


def test_a_filter_that_is_worse_than_a_polyline_says_so(rig_folder):
    model = load_model(rig_folder / "model.toml")
    save_model(model.with_values({"expansion_error.error": 0.04}), rig_folder / "poor.toml")
    poor = ("review", rig_folder / "logs", "--model", rig_folder / "poor.toml", "--no-displacement")
    out, _ = ended(0, *poor)
    assert "is worse than the polyline" in out
    assert "`ballscrew diagnose` says where" in out
    assert "worse than the polyline" not in run("review", rig_folder / "logs")[1]
    assert "worse than the polyline" not in run(*poor, "--mute", "telemeter:20-30")[1]  # which the polyline sees


def test_the_nearest_rig_folder_is_used(short_folder):
    rig = short_folder / "rig.toml"
    rig.write_text(rig.read_text().replace('subset_7 = ["T02", ', 'subset_7 = ["T01", '))
    out, err = ended(0, "review", short_folder / "logs", "--json")
    assert "built-in" not in out + err
    nearest = json.loads(out)["recordings"][0]["polyline_7"]
    named = [json_of("review", short_folder / "logs", "--rig", path) for path in (rig, short_folder, PAPER)]
    assert [found["recordings"][0]["polyline_7"] == nearest for found in named] == [True, True, False]


def test_a_folder_means_its_recordings_and_never_the_truth(short_folder):
    assert [r["name"] for r in json_of("review", short_folder / "logs")["recordings"]] == ["FS-20.log"]
    _, err = ended(1, "review", short_folder / "logs" / "FS-20.truth.csv")
    assert "FS-20.truth.csv: the truth of a simulated recording, not a recording" in err


def test_recordings_of_one_name_are_named_with_their_folders(short_folder, monkeypatch):
    monkeypatch.chdir(short_folder)
    shutil.copytree("logs", "tuesday")
    names = [r["name"] for r in json_of("review", "logs", "tuesday")["recordings"]]
    assert names == ["FS-20.log (logs)", "FS-20.log (tuesday)"]


def test_wrong_rig_and_model_end_with_2(short_folder):
    log = short_folder / "logs" / "FS-20.log"
    (short_folder / "model.toml").write_text("[nut_friction]\npowr = 3\n")
    _, err = ended(2, "review", log)
    assert (
        err.strip()
        == f"error: {short_folder.resolve() / 'model.toml'}: nut_friction has no 'powr'; did you mean 'power'?"
    )
    (short_folder / "model.toml").unlink()
    assert run("review", log)[0] == 2
    assert run("review", log, "--model", PAPER / "model.toml")[0] == 0
    (short_folder / "rig.toml").write_text("name = 3")
    assert run("review", log)[0] == 2
    assert run("review", log, "--rig", short_folder / "none")[0] == 2


def test_a_model_of_another_geometry_is_said(short_folder):
    text = (short_folder / "rig.toml").read_text()
    (short_folder / "rig.toml").write_text(text.replace("conductivity = 46.0", "conductivity = 45.0"))
    _, _, err = run("review", short_folder / "logs", "--model", PAPER / "model.toml")
    assert "was fitted to another geometry or material than" in err
    (short_folder / "rig.toml").write_text(text)
    assert "another geometry" not in run("review", short_folder / "logs", "--model", PAPER / "model.toml")[2]


def test_a_spoilt_truth_is_said_and_the_readings_serve(short_folder):
    (short_folder / "logs" / "FS-20.truth.csv").write_text("time_s,elongation_um\n0,x\n")
    out, err = ended(1, "review", short_folder / "logs", "--json")
    assert "FS-20.truth.csv: cannot be read as a truth file" in err
    assert json.loads(out)["recordings"][0]["reference"] == "readings"


def test_thermometers_that_are_all_out_of_range_are_told_with_what_the_dbc_says(tmp_path):
    text = (ROOT / "drivers" / "rig.dbc").read_text()
    (tmp_path / "rig.dbc").write_text(
        re.sub(r'(SG_ T\d\d : \S+ )\(0.01,0\)( \S+ )"degC"', r'\1(0.01,273.15)\2"K"', text)
    )
    for name in ("rig.toml", "model.toml"):
        shutil.copy(ROOT / "recordings" / name, tmp_path)
    log_fake.write(tmp_path / "a.log", log_fake.log(12))
    _, err = ended(1, "review", tmp_path / "a.log")
    assert "in K by rig.dbc, in degC by rig.toml: convert there, scale and offset; 12 x out of range T01" in err
    assert err.count("\n") == 1
