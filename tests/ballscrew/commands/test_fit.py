"""`ballscrew fit` and `show`: the model that is written, the table, the JSON; and the truth stays closed."""

import json
import shutil
import tomllib
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from unittest import mock

import pytest

from ballscrew.terminal import Terminal
from estimator.rig_folder.model_toml import load_model, save_model
from tests.ballscrew.conftest import FREE
from tests.conftest import PAPER, ballscrew as run, ended, json_of


def test_fit_writes_a_model_that_review_calls_fitted(rig_folder):
    out = rig_folder / "new.toml"
    told = json_of("fit", rig_folder / "logs", "-o", out)
    assert set(told["parameters"]) == FREE
    assert told["converged"]
    assert told["open_loop"]["after"]["temperature_K"] < told["open_loop"]["before"]["temperature_K"]
    model = load_model(out)
    for path in FREE:
        assert model[path] == pytest.approx(told["parameters"][path]["value"], rel=1e-4)
    assert list(model.about["fitted_on"]) == ["FS-20.log"]
    copy = rig_folder / "logs" / "copy.log"
    shutil.copy(rig_folder / "logs" / "FS-20.log", copy)
    assert json_of("review", copy, "--model", out)["held_out"] is None
    assert json_of("review", copy)["held_out"] is not None


def test_fit_never_opens_the_truth(short_folder):
    opened = []
    real = Path.open
    spy = mock.patch.object(Path, "open", lambda self, *a, **k: opened.append(self.name) or real(self, *a, **k))
    with spy:
        assert run("fit", short_folder / "logs", "-o", short_folder / "with.toml")[0] == 0
        assert "FS-20.truth.csv" not in opened
        assert run("review", short_folder / "logs")[0] == 0
        assert "FS-20.truth.csv" in opened
    (short_folder / "logs" / "FS-20.truth.csv").write_bytes(b"\xff not a table")
    assert run("fit", short_folder / "logs", "-o", short_folder / "spoilt.toml")[0] == 0
    assert (short_folder / "with.toml").read_text() == (short_folder / "spoilt.toml").read_text()


def test_fit_without_free_parameters_ends_with_2(rig_folder):
    text = (rig_folder / "model.toml").read_text()
    (rig_folder / "model.toml").write_text(text.replace("fixed = false", "fixed = true"))
    _, err = ended(2, "fit", rig_folder / "logs", "-o", rig_folder / "m.toml")
    assert "every parameter is fixed; nothing to fit" in err
    assert not (rig_folder / "m.toml").exists()


def test_fit_says_in_a_table_what_changed_and_as_json_all_it_knows(rig_folder):
    out = rig_folder / "new.toml"
    status, text, _ = run("fit", rig_folder / "logs", "-o", out, "--json", rig_folder / "fit.json")
    told = json.loads((rig_folder / "fit.json").read_text())
    assert status == 0
    for path in FREE:
        fitted = told["parameters"][path]
        assert set(fitted) == {"before", "value", "sd", "unit", "at_bound", "determined", "like"}
        (line,) = [line for line in text.splitlines() if line.startswith(path)]
        assert line.split()[1:5] == [f"{fitted[key]:.{digits}g}" for key, digits in (("before", 4), ("value", 4))] + [
            f"{fitted['sd']:.2g}", "W",
        ]  # fmt: skip
    assert set(told) == {
        "parameters", "one_step", "ahead", "open_loop", "process_noise_raised", "thermometer_noise_raised",
        "correlated", "converged", "stopped", "steps", "recordings",
    }  # fmt: skip
    assert told["ahead"]["after"]["temperature_K"] is None  # seven minutes
    assert f"model: {out}" in text


@pytest.mark.parametrize("stage", ["open loop", "likelihood"])
def test_ctrl_c_in_a_fit_ends_with_130_and_the_model_written(short_folder, stage):
    model = load_model(short_folder / "model.toml")
    noisy = {"thermometers.sd": replace(model.values["thermometers.sd"], fixed=False)}
    save_model(model.with_values(noisy), short_folder / "model.toml")

    def interrupt(done: float, detail: str = "") -> None:
        if detail.startswith(f"{stage}, run"):
            raise KeyboardInterrupt

    out = short_folder / "so_far.toml"
    with mock.patch.object(Terminal, "progress", return_value=nullcontext(interrupt)):
        status, text, err = run("fit", short_folder / "logs", "-o", out, "--json", short_folder / "fit.json")
    told = json.loads((short_folder / "fit.json").read_text())
    assert status == 130
    assert "stopped by Ctrl-C after " in text
    assert "Traceback" not in err
    assert told["stopped"]
    assert not told["converged"]
    model = load_model(out)
    for path in FREE:
        assert model[path] == pytest.approx(told["parameters"][path]["value"], rel=1e-4)


def test_a_quiet_fit_is_silent_and_writes_the_model_all_the_same(short_folder):
    assert run("fit", short_folder / "logs", "-o", short_folder / "m.toml", "--quiet") == (0, "", "")
    assert set(load_model(short_folder / "m.toml").values) == set(load_model(short_folder / "model.toml").values)


def test_show_prints_every_effect_with_equation_values_and_units(full):
    out, _ = ended(0, "show", PAPER / "model.toml")
    for name, effect in full.effects.items():
        assert name in out
        assert effect.equation().splitlines()[0] in out
        assert all(param.unit in out for param in effect.params.values())
    assert "fitted on FS-20.blf, FS-5.blf, CS-10.blf, ES-2.5.blf" in out


def test_show_as_json_is_the_model_file(full):
    told = json_of("show", PAPER / "model.toml")
    table = tomllib.loads((PAPER / "model.toml").read_text())
    assert told["about"] == table.pop("about")
    assert list(told["effects"]) == list(table)
    for name, effect in told["effects"].items():
        for key, parameter in effect["parameters"].items():
            entry = table[name][key]
            assert parameter["value"] == pytest.approx(entry["value"] if isinstance(entry, dict) else entry)
            assert parameter["unit"] == full.param(f"{name}.{key}").unit
