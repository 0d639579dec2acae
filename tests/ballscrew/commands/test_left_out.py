"""Offline commands name the channels that they leave out: a rod whose thermometers fail, on purpose and with times."""

import csv
import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import ROD, ended, json_of
from tests.viz_read import fixed, rows

FROM, TO, END, TICK_S = 300, 340, 480, 5  # rows
ALL = [f"TC{i}" for i in range(1, 9)]

Rows = dict[str, np.ndarray]


def written(break_: Callable[[Rows], None], folder: Path) -> Path:
    """The first part of the rod's recording after `break_` has changed its columns, in a rig folder."""
    for name in ("rig.toml", "model.toml", "effects.py"):
        shutil.copy(ROD / name, folder)
    names, *cells = csv.reader((ROD / "check.csv").read_text().splitlines()[: END + 1])
    rows = dict(zip(names, np.array(cells, dtype=float).T, strict=True))
    break_(rows)
    lines = [",".join(f"{x:.2f}" for x in row) for row in zip(*rows.values(), strict=True)]
    path = folder / "run.csv"
    path.write_text("\n".join([",".join(names), *lines]) + "\n")
    return path


def powered_on_again(rows: Rows) -> None:
    rows["TC4"][FROM:TO] = 85.0


def wire_off(rows: Rows) -> None:
    rows["TC4"][FROM:] = 0.0


def not_converted_yet(rows: Rows) -> None:
    for name in ALL:
        rows[name][:3] = 85.0


def without_the_first(rows: Rows) -> None:
    for name in rows:
        rows[name] = rows[name][3:]


def a_noisy_plug(rows: Rows) -> None:
    rows["TC4"] += 0.4 * np.random.default_rng(3).standard_normal(len(rows["TC4"]))


def another_reference(rows: Rows) -> None:
    for name in ALL:
        rows[name][FROM:] += 3.0


def began_elsewhere(rows: Rows) -> None:
    for name in ALL:
        rows[name][:3] = 60.0


def reviewed(path: Path) -> tuple[dict, str]:
    """The one recording in the JSON of a review, and what is printed beside."""
    out, err = ended(0, "review", path, "--json")
    (recording,) = json.loads(out)["recordings"]
    return recording, err


def test_nothing_is_said_of_a_rod_that_is_well():
    recording, said = reviewed(ROD / "check.csv")
    assert "not used" not in said
    assert "check that sensor" not in said
    for one in recording["channels"].values():
        assert (one["used"], one["refused"], one["why"], one["suspect"], one["spells"]) == (1.0, 0, {}, None, [])
        assert 0.3 < one["nis"] < 1.5
    assert (recording["jumps"], recording["begun"]) == ([], {"at_s": 0.0, "again": False})


def test_a_review_names_a_thermometer_that_restarted_and_counts_what_it_refused(tmp_path):
    recording, said = reviewed(written(powered_on_again, tmp_path))
    one = recording["channels"]["TC4"]
    assert one["suspect"] == "stuck"
    assert TO - FROM <= one["refused"] <= TO - FROM + 13
    assert sum(one["why"].values()) == one["refused"]
    (spell,) = one["spells"]
    assert spell["from_s"] == FROM * TICK_S
    assert TO * TICK_S < spell["to_s"] <= (TO + 13) * TICK_S
    assert {recording["channels"][name]["refused"] for name in ALL if name != "TC4"} == {0}
    assert "TC4 at 170 mm was stuck from 1500 s to" in said
    assert f"readings not used: TC4: {one['why']['stuck']} x stuck" in said
    (tmp_path / "well").mkdir()
    well, _ = reviewed(written(lambda rows: None, tmp_path / "well"))
    assert recording["temperature_K"] == pytest.approx(well["temperature_K"], rel=0.02)


def test_a_review_says_that_a_thermometer_is_broken_to_the_end(tmp_path):
    recording, said = reviewed(written(wire_off, tmp_path))
    assert recording["channels"]["TC4"]["spells"] == [{"fault": "stuck", "from_s": 1500.0, "to_s": None}]
    assert "TC4 at 170 mm is stuck, since 1500 s: left out, check that sensor" in said
    assert recording["off_sd"] < 1.0
    assert "ballscrew fit" not in said


def test_a_nis_far_above_1_names_the_channel_that_it_comes_from(tmp_path):
    recording, said = reviewed(written(a_noisy_plug, tmp_path))
    others = [one["nis"] for name, one in recording["channels"].items() if name != "TC4"]
    assert max(others) < 2
    assert recording["channels"]["TC4"]["nis"] > 9
    assert f"NIS {recording['channels']['TC4']['nis']:.0f} of TC4 at 170 mm: check that sensor first" in said
    assert "ballscrew fit" not in said


def test_a_nis_far_above_1_of_all_channels_is_the_model_s(tmp_path):
    log = written(lambda rows: None, tmp_path)
    model = tmp_path / "model.toml"
    model.write_text(model.read_text().replace("sd = 0.05 # K", "sd = 0.01 # K"))
    recording, said = reviewed(log)
    times = f"{np.sqrt(recording['nis_mean']):.1f} times as far off as the filter expects"
    assert f"NIS {recording['nis_mean']:.0f}: readings are {times}; `ballscrew diagnose` says where" in said


def test_values_after_power_on_are_no_start(tmp_path):
    recording, said = reviewed(written(not_converted_yet, tmp_path))
    assert recording["begun"] == {"at_s": 3.0 * TICK_S, "again": False}
    assert all(recording["channels"][name]["why"] == {"power-on value": 3} for name in ALL)
    assert "all thermometers, TC1 ... TC8: 3 x power-on value" in said
    (tmp_path / "well").mkdir()
    well, _ = reviewed(written(without_the_first, tmp_path / "well"))
    assert recording["temperature_K"] == pytest.approx(well["temperature_K"], abs=1e-5)


def test_a_run_that_began_with_no_temperatures_is_said_to_have_begun_again(tmp_path):
    recording, said = reviewed(written(began_elsewhere, tmp_path))
    begun = recording["begun"]
    assert begun["again"]
    assert 3 * TICK_S <= begun["at_s"] <= 60
    assert f"begun again at {begun['at_s']:.0f} s" in said
    assert recording["channels"]["TC1"]["why"] == {"before the start": begun["at_s"] / TICK_S}
    assert recording["temperature_K"]["open_loop"] < 0.08


def test_all_thermometers_that_jump_together_are_said_to_have_other_zeros(tmp_path):
    recording, said = reviewed(written(another_reference, tmp_path))
    (jump,) = recording["jumps"]
    assert FROM * TICK_S <= jump["at_s"] <= (FROM + 6) * TICK_S
    assert sorted(jump["sizes"]) == ALL
    assert list(jump["sizes"].values()) == pytest.approx([3.0] * 8, abs=0.3)
    assert "all thermometers jumped by" in said
    assert f"K at {jump['at_s']:.0f} s: their zeros are others from then on" in said


@pytest.fixture(scope="module")
def dead(tmp_path_factory) -> Path:
    """The rod's recording with a wire off, in its rig folder."""
    return written(wire_off, tmp_path_factory.mktemp("dead"))


@pytest.mark.parametrize(
    "words",
    [
        ["compare"],
        ["diagnose"],
        ["fit", "-o", "m.toml"],
        ["tune", "-o", "m.toml"],
        ["suggest"],
        ["improve", "-o", "m.toml"],
    ],
    ids=lambda words: words[0],
)
@pytest.mark.usefixtures("undrawn", "unfelt")
def test_every_offline_command_leaves_it_out_and_says_so(words, dead, tmp_path):
    words = [tmp_path / word if word == "m.toml" else word for word in words]
    out, said = ended(0, *words, dead, "--json")
    told = json.loads(out)
    told = told["models"][0] if words[0] == "compare" else told
    (recording,) = told["recordings"]
    assert recording["name"] == "run.csv"
    assert {name for name, one in recording["channels"].items() if one["suspect"]} == {"TC4"}
    assert recording["channels"]["TC4"]["refused"] == END - FROM
    assert "run.csv: TC4 at 170 mm is stuck, since 1500 s: left out, check that sensor" in said
    assert "readings not used: TC4: " in said
    if words[0] == "improve":
        assert "| run.csv | TC4 at 170 mm | stuck | 1500 s | the end | 180 |" in (tmp_path / "m.md").read_text()


def test_views_of_a_review_tell_it_in_a_table_and_in_a_lane(tmp_path):
    ended(0, "review", written(powered_on_again, tmp_path), "--save", tmp_path / "v.rrd", "--quiet")
    assert re.search(
        r"\| run.csv \| TC4 at 170 mm \| (stuck|jumped) \| 1500 s \| 17\d\d s \| [45]\d \|",
        fixed(tmp_path / "v.rrd", "/summary", "TextDocument:text")[0],
    )
    time_s, states = rows(tmp_path / "v.rrd", "/run/state/faults/stuck", "StateChange:state")
    assert time_s[0] == 1500.0
    assert TO * TICK_S < time_s[-1] <= (TO + 13) * TICK_S
    assert (states[0], states[-1]) == (["TC4"], [""])


def test_views_of_a_rod_that_is_well_have_neither(tmp_path):
    ended(0, "review", ROD / "check.csv", "--save", tmp_path / "v.rrd", "--quiet")
    assert "Sensors that failed" not in fixed(tmp_path / "v.rrd", "/summary", "TextDocument:text")[0]
    assert {*np.ravel(rows(tmp_path / "v.rrd", "/check/state/estimate", "StateChange:state")[1])} == {"valid"}


def test_parameters_are_those_of_the_other_thermometers(dead, tmp_path):
    """What a dead thermometer read for most of the run bends no parameter."""
    ours = parameters(dead, tmp_path / "a.toml")
    theirs = parameters(ROD / "check.csv", tmp_path / "b.toml")
    for path, one in theirs.items():
        assert abs(ours[path]["value"] - one["value"]) < 4 * one["sd"], path


def parameters(log: Path, out: Path) -> dict[str, dict]:
    return {path: one for path, one in json_of("fit", log, "-o", out)["parameters"].items() if one["sd"]}
