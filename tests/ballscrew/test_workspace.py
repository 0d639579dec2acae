"""What a command works on: rig folders, models, recordings; and that a fit never sees the truth."""

from __future__ import annotations

import json
import re
import shutil
import tomllib
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from unittest import mock

import pytest

from ballscrew.terminal import Terminal
from estimator.rig_folder.model_toml import load_model, save_model
from tests import log_fake
from tests.conftest import ballscrew as run

PAPER = Path(__file__).parents[2] / "recordings"
ROOT = Path(__file__).parents[2]
ROD = ROOT / "examples" / "heated_rod"
FREE = {"nut_friction.power", "anchor_friction.power"}


@pytest.fixture
def folder(fs20_log, tmp_path) -> Path:
    """A rig folder: rig, model with two free parameters, and FS-20 with its truth in a folder below."""
    shutil.copy(PAPER / "rig.toml", tmp_path)
    model = load_model(PAPER / "model.toml")
    lines = [
        f'[{name}]\n' + "".join(
            f"{key} = {{value = {model[path]}, fixed = {str(path not in FREE).lower()}}}\n"
            for key, path in ((key, f"{name}.{key}") for key in effect.params)
        )
        for name, effect in model.effects.items()
    ]  # fmt: skip
    (tmp_path / "model.toml").write_text("\n".join(lines))
    (tmp_path / "logs").mkdir()
    for path in (fs20_log, fs20_log.with_name("FS-20.truth.csv")):
        shutil.copy(path, tmp_path / "logs")
    return tmp_path


def test_without_a_rig_file_above_the_built_in_rig_is_used_and_named(fs20_log):
    status, out, _ = run("review", fs20_log)
    assert status == 0
    assert "no rig.toml at or above" in out
    assert "using the built-in rig, the paper's ball screw" in out


@pytest.mark.parametrize("option", ["--json", "--save"])
def test_an_output_that_cannot_be_written_is_told_before_the_work(option, folder):
    (blocked := folder / "out.json").mkdir()
    with mock.patch("ballscrew.workspace.load", side_effect=AssertionError("work was begun")):
        status, _, err = run("review", folder / "logs", option, blocked)
    assert status == 2
    assert f"error: {blocked}: cannot be written: is a directory" in err


def test_asking_whether_an_output_can_be_written_changes_nothing(folder):
    kept = folder / "kept.json"
    kept.write_text("{}")
    assert run("review", folder / "none.log", "--json", kept)[0] == 1
    assert run("review", folder / "none.log", "--json", folder / "new.json")[0] == 1
    assert kept.read_text() == "{}"
    assert not (folder / "new.json").exists()


@pytest.mark.parametrize("text", ["", "[conduction]\n", "[still_air]\n[conduction]\n"])
def test_a_model_that_reads_no_thermometer_is_refused(text, folder):
    (folder / "model.toml").write_text(text)
    status, _, err = run("review", folder / "logs")
    assert status == 2
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
    status, out, err = run("review", rod / "blind.csv", good)
    assert status == 1
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
    status, out, _ = run("review", log)
    assert status == 0
    told = [line for line in out.splitlines() if line.startswith("steps.csv: ")]
    assert told[1] == "steps.csv: input heater was never read: 0 stands for it"
    assert json.loads(run("review", log, "--json")[1])["recordings"][0]["inputs_never_read"] == ["heater"]


def test_a_copy_of_a_recording_is_no_other_witness(tmp_path):
    shutil.copytree(ROD, tmp_path / "rod")
    log = tmp_path / "rod" / "steps.csv"
    log.write_text("".join(log.read_text().splitlines(keepends=True)[:200]))
    shutil.copy(log, tmp_path / "rod" / "copy.csv")
    status, out, err = run("suggest", log, tmp_path / "rod" / "copy.csv", "--json")
    assert status == 0
    assert "copy.csv is steps.csv once more: used once" in err
    assert [one["name"] for one in json.loads(out)["recordings"]] == ["steps.csv"]


def test_a_filter_that_is_worse_than_a_polyline_says_so(folder):
    model = load_model(folder / "model.toml")
    save_model(model.with_values({"expansion_error.error": 0.04}), folder / "poor.toml")
    status, out, _ = run("review", folder / "logs", "--model", folder / "poor.toml", "--no-displacement")
    assert status == 0
    assert "is worse than the polyline" in out
    assert "`ballscrew diagnose` says where" in out
    assert "worse than the polyline" not in run("review", folder / "logs")[1]


def test_the_nearest_rig_folder_is_used(folder):
    rig = folder / "rig.toml"
    rig.write_text(rig.read_text().replace('subset_7 = ["T02", ', 'subset_7 = ["T01", '))
    status, out, err = run("review", folder / "logs", "--json")
    assert status == 0
    assert "built-in" not in out + err
    nearest = json.loads(out)["recordings"][0]["polyline_7"]
    named = [json.loads(run("review", folder / "logs", "--rig", path, "--json")[1]) for path in (rig, folder, PAPER)]
    assert [found["recordings"][0]["polyline_7"] == nearest for found in named] == [True, True, False]


def test_a_folder_means_its_recordings_and_never_the_truth(folder):
    status, out, _ = run("review", folder / "logs", "--json")
    assert status == 0
    assert [r["name"] for r in json.loads(out)["recordings"]] == ["FS-20.log"]
    status, _, err = run("review", folder / "logs" / "FS-20.truth.csv")
    assert status == 1
    assert "FS-20.truth.csv: the truth of a simulated recording, not a recording" in err


def test_recordings_of_one_name_are_named_with_their_folders(folder, monkeypatch):
    monkeypatch.chdir(folder)
    shutil.copytree("logs", "tuesday")
    status, out, _ = run("review", "logs", "tuesday", "--json")
    assert status == 0
    names = [r["name"] for r in json.loads(out)["recordings"]]
    assert names == ["FS-20.log (logs)", "FS-20.log (tuesday)"]


def test_wrong_rig_and_model_end_with_2(folder):
    log = folder / "logs" / "FS-20.log"
    (folder / "model.toml").write_text("[nut_friction]\npowr = 3\n")
    status, _, err = run("review", log)
    assert status == 2
    assert err.strip() == f"error: {folder.resolve() / 'model.toml'}: nut_friction has no 'powr'; did you mean 'power'?"
    (folder / "model.toml").unlink()
    assert run("review", log)[0] == 2
    assert run("review", log, "--model", PAPER / "model.toml")[0] == 0
    (folder / "rig.toml").write_text("name = 3")
    assert run("review", log)[0] == 2
    assert run("review", log, "--rig", folder / "none")[0] == 2


def test_a_model_of_another_geometry_is_said(folder):
    text = (folder / "rig.toml").read_text()
    (folder / "rig.toml").write_text(text.replace("conductivity = 46.0", "conductivity = 45.0"))
    _, _, err = run("review", folder / "logs", "--model", PAPER / "model.toml")
    assert "was fitted to another geometry or material than" in err
    (folder / "rig.toml").write_text(text)
    assert "another geometry" not in run("review", folder / "logs", "--model", PAPER / "model.toml")[2]


def test_a_spoilt_truth_is_said_and_the_readings_serve(folder):
    (folder / "logs" / "FS-20.truth.csv").write_text("time_s,elongation_um\n0,x\n")
    status, out, err = run("review", folder / "logs", "--json")
    assert status == 1
    assert "FS-20.truth.csv: cannot be read as a truth file" in err
    assert json.loads(out)["recordings"][0]["reference"] == "readings"


def test_fit_writes_a_model_that_review_calls_fitted(folder):
    out = folder / "new.toml"
    status, text, _ = run("fit", folder / "logs", "-o", out, "--json")
    told = json.loads(text)
    assert status == 0
    assert set(told["parameters"]) == FREE
    assert told["converged"]
    assert told["open_loop"]["after"]["temperature_K"] < told["open_loop"]["before"]["temperature_K"]
    model = load_model(out)
    for path in FREE:
        assert model[path] == pytest.approx(told["parameters"][path]["value"], rel=1e-4)
    assert list(model.about["fitted_on"]) == ["FS-20.log"]
    copy = folder / "logs" / "copy.log"
    shutil.copy(folder / "logs" / "FS-20.log", copy)
    assert json.loads(run("review", copy, "--model", out, "--json")[1])["held_out"] is None
    assert json.loads(run("review", copy, "--json")[1])["held_out"] is not None


def test_fit_never_opens_the_truth(folder):
    opened = []
    real = Path.open
    spy = mock.patch.object(Path, "open", lambda self, *a, **k: opened.append(self.name) or real(self, *a, **k))
    with spy:
        assert run("fit", folder / "logs", "-o", folder / "with.toml")[0] == 0
        assert "FS-20.truth.csv" not in opened
        assert run("review", folder / "logs")[0] == 0
        assert "FS-20.truth.csv" in opened
    (folder / "logs" / "FS-20.truth.csv").write_bytes(b"\xff not a table")
    assert run("fit", folder / "logs", "-o", folder / "spoilt.toml")[0] == 0
    assert (folder / "with.toml").read_text() == (folder / "spoilt.toml").read_text()


def test_fit_without_free_parameters_ends_with_2(folder):
    text = (folder / "model.toml").read_text()
    (folder / "model.toml").write_text(text.replace("fixed = false", "fixed = true"))
    status, _, err = run("fit", folder / "logs", "-o", folder / "m.toml")
    assert status == 2
    assert "every parameter is fixed; nothing to fit" in err
    assert not (folder / "m.toml").exists()


def test_fit_says_in_a_table_what_changed_and_as_json_all_it_knows(folder):
    out = folder / "new.toml"
    status, text, _ = run("fit", folder / "logs", "-o", out, "--json", folder / "fit.json")
    told = json.loads((folder / "fit.json").read_text())
    assert status == 0
    for path in FREE:
        fitted = told["parameters"][path]
        assert set(fitted) == {"before", "value", "sd", "unit", "at_bound", "determined", "like"}
        (line,) = [line for line in text.splitlines() if line.startswith(path)]
        assert line.split()[1:5] == [f"{fitted[key]:.{digits}g}" for key, digits in (("before", 4), ("value", 4))] + [
            f"{fitted['sd']:.2g}", "W",
        ]  # fmt: skip
    assert set(told) == {
        "parameters", "one_step", "ahead", "open_loop", "process_noise_raised", "correlated", "converged", "stopped",
        "steps", "recordings",
    }  # fmt: skip
    assert told["ahead"]["after"]["temperature_K"] is None  # seven minutes
    assert f"model: {out}" in text


@pytest.mark.parametrize("stage", ["open loop", "likelihood"])
def test_ctrl_c_in_a_fit_ends_with_130_and_the_model_written(folder, stage):
    model = load_model(folder / "model.toml")
    noisy = {"thermometers.sd": replace(model.values["thermometers.sd"], fixed=False)}
    save_model(model.with_values(noisy), folder / "model.toml")

    def interrupt(done: float, detail: str = "") -> None:
        if detail.startswith(f"{stage}, run"):
            raise KeyboardInterrupt

    out = folder / "so_far.toml"
    with mock.patch.object(Terminal, "progress", return_value=nullcontext(interrupt)):
        status, text, err = run("fit", folder / "logs", "-o", out, "--json", folder / "fit.json")
    told = json.loads((folder / "fit.json").read_text())
    assert status == 130
    assert "stopped by Ctrl-C after " in text
    assert "Traceback" not in err
    assert told["stopped"]
    assert not told["converged"]
    model = load_model(out)
    for path in FREE:
        assert model[path] == pytest.approx(told["parameters"][path]["value"], rel=1e-4)


def test_a_quiet_fit_is_silent_and_writes_the_model_all_the_same(folder):
    assert run("fit", folder / "logs", "-o", folder / "m.toml", "--quiet") == (0, "", "")
    assert set(load_model(folder / "m.toml").values) == set(load_model(folder / "model.toml").values)


def test_tune_writes_a_model_of_other_noise_levels_and_nothing_else(folder):
    """From thermometers said to be twice as good as they are."""
    out = folder / "tuned.toml"
    save_model(load_model(folder / "model.toml").with_values({"thermometers.sd": 0.01}), folder / "model.toml")
    status, text, _ = run("tune", folder / "logs", "-o", out, "--json")
    told = json.loads(text)
    assert status == 0
    before, after = load_model(folder / "model.toml"), load_model(out)
    assert {level["of"] for level in told["levels"].values()} == {"measurement", "process"}
    for path, value in before.values.items():
        if path in told["levels"]:
            level = told["levels"][path]
            assert level["before"] == pytest.approx(value.value, rel=1e-4)
            assert after[path] == pytest.approx(level["after"], rel=1e-4), path
            assert after.values[path].fixed == value.fixed
        else:
            assert after.values[path] == value, path
    assert after["thermometers.sd"] > 0.015
    assert told["process_factor"] == 1.0  # seven minutes: nothing was blind for ten


def test_tune_says_in_a_table_what_changed_and_as_json_all_it_knows(tmp_path):
    """On the rod's committed run of more than an hour, from a model that is too sure of itself."""
    sure = {"conduction.noise": 0.02, "thermometers.sd": 0.1, "thermometers.lag_noise": 0.0}
    save_model(load_model(ROD / "model.toml").with_values(sure), tmp_path / "sure.toml")
    words = ["tune", ROD / "steps.csv", "--model", tmp_path / "sure.toml", "-o", tmp_path / "tuned.toml"]
    status, text, _ = run(*words, "--json", tmp_path / "tune.json")
    told = json.loads((tmp_path / "tune.json").read_text())
    assert status == 0
    assert {
        "levels", "channels", "errors", "noise_floor", "process_factor", "missing_physics", "sentences",
    } <= set(told)  # fmt: skip
    assert told["levels"]["thermometers.sd"]["after"] == pytest.approx(0.05, rel=0.05)
    assert told["levels"]["conduction.noise"]["after"] == pytest.approx(0.02 * told["process_factor"], rel=1e-4)
    assert told["channels"]["TC1"]["nis"]["after"] == pytest.approx(1.0, abs=0.15)
    assert told["noise_floor"]["elongation_um"] is None
    for path, level in told["levels"].items():
        (line,) = [line for line in text.splitlines() if line.startswith(path)]
        numbers = [f"{level[key]:.4g}" for key in ("before", "after")]
        assert " ".join(line.split()) == " ".join([path, level["of"], *numbers, level["unit"]])
    assert all(sentence in text for sentence in told["sentences"])
    assert f"model: {tmp_path / 'tuned.toml'}" in text
    assert load_model(tmp_path / "tuned.toml")["heater.share"] == load_model(ROD / "model.toml")["heater.share"]


def test_a_quiet_tune_is_silent_and_never_opens_the_truth(folder):
    (folder / "logs" / "FS-20.truth.csv").write_bytes(b"\xff not a table")
    opened = []
    real = Path.open
    spy = mock.patch.object(Path, "open", lambda self, *a, **k: opened.append(self.name) or real(self, *a, **k))
    with spy:
        assert run("tune", folder / "logs", "-o", folder / "tuned.toml", "--quiet") == (0, "", "")
    assert "FS-20.truth.csv" not in opened
    assert "model.toml" in opened
    assert set(load_model(folder / "tuned.toml").values) == set(load_model(folder / "model.toml").values)


def test_ctrl_c_in_tuning_ends_with_130_and_no_model(tmp_path):
    interrupt = mock.patch("estimator.fit.tune.blind", side_effect=KeyboardInterrupt)
    with interrupt:
        status, _, err = run("tune", ROD / "steps.csv", "-o", tmp_path / "tuned.toml")
    assert status == 130
    assert err.splitlines()[-1] == "stopped by Ctrl-C"
    assert not (tmp_path / "tuned.toml").exists()


def test_show_prints_every_effect_with_equation_values_and_units(full):
    status, out, _ = run("show", PAPER / "model.toml")
    assert status == 0
    for name, effect in full.effects.items():
        assert name in out
        assert effect.equation().splitlines()[0] in out
        assert all(param.unit in out for param in effect.params.values())
    assert "fitted on FS-20.blf, FS-5.blf, CS-10.blf, ES-2.5.blf" in out


def test_show_as_json_is_the_model_file(full):
    told = json.loads(run("show", PAPER / "model.toml", "--json")[1])
    table = tomllib.loads((PAPER / "model.toml").read_text())
    assert told["about"] == table.pop("about")
    assert list(told["effects"]) == list(table)
    for name, effect in told["effects"].items():
        for key, parameter in effect["parameters"].items():
            entry = table[name][key]
            assert parameter["value"] == pytest.approx(entry["value"] if isinstance(entry, dict) else entry)
            assert parameter["unit"] == full.param(f"{name}.{key}").unit


def test_thermometers_that_are_all_out_of_range_are_told_with_what_the_dbc_says(tmp_path):
    text = (ROOT / "drivers" / "rig.dbc").read_text()
    (tmp_path / "rig.dbc").write_text(
        re.sub(r'(SG_ T\d\d : \S+ )\(0.01,0\)( \S+ )"degC"', r'\1(0.01,273.15)\2"K"', text)
    )
    for name in ("rig.toml", "model.toml"):
        shutil.copy(ROOT / "recordings" / name, tmp_path)
    log_fake.write(tmp_path / "a.log", log_fake.log(12))
    status, _, err = run("review", tmp_path / "a.log")
    assert status == 1
    assert "in K by rig.dbc, in degC by rig.toml: convert there, scale and offset; 12 x out of range T01" in err
    assert err.count("\n") == 1
