"""Offline commands name the channels that they leave out: a rod whose thermometers fail, on purpose and with times."""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import ballscrew as run

ROD = Path(__file__).parents[3] / "examples" / "heated_rod"
FROM, TO, TICK_S = 300, 340, 5  # rows
ALL = [f"TC{i}" for i in range(1, 9)]

Rows = dict[str, np.ndarray]


@pytest.fixture
def rod(tmp_path) -> Callable[[Callable[[Rows], None]], Path]:
    """rod(break_): the rod's recording after `break_` has changed its columns, in a rig folder."""
    for name in ("rig.toml", "model.toml", "effects.py"):
        shutil.copy(ROD / name, tmp_path)

    def broken(break_: Callable[[Rows], None]) -> Path:
        names, *cells = csv.reader((ROD / "check.csv").read_text().splitlines())
        rows = dict(zip(names, np.array(cells, dtype=float).T, strict=True))
        break_(rows)
        lines = [",".join(f"{x:.2f}" for x in row) for row in zip(*rows.values(), strict=True)]
        path = tmp_path / "run.csv"
        path.write_text("\n".join([",".join(names), *lines]) + "\n")
        return path

    return broken


def powered_on_again(rows: Rows) -> None:
    rows["TC4"][FROM:TO] = 85.0


def wire_off(rows: Rows) -> None:
    rows["TC4"][FROM:] = 0.0


def not_converted_yet(rows: Rows) -> None:
    for name in ALL:
        rows[name][:3] = 85.0


def another_reference(rows: Rows) -> None:
    for name in ALL:
        rows[name][FROM:] += 3.0


def began_elsewhere(rows: Rows) -> None:
    for name in ALL:
        rows[name][:3] = 60.0


def reviewed(path: Path) -> tuple[dict, str]:
    """The one recording in the JSON of a review, and what is printed beside."""
    status, out, err = run("review", path, "--json")
    assert status == 0, err
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


def test_a_review_names_a_thermometer_that_restarted_and_counts_what_it_refused(rod):
    recording, said = reviewed(rod(powered_on_again))
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
    assert recording["temperature_K"]["one_step"] == pytest.approx(0.050, abs=0.002)
    assert recording["temperature_K"]["open_loop"] == pytest.approx(0.051, abs=0.002)


def test_a_review_says_that_a_thermometer_is_broken_to_the_end(rod):
    recording, said = reviewed(rod(wire_off))
    assert recording["channels"]["TC4"]["spells"] == [{"fault": "stuck", "from_s": 1500.0, "to_s": None}]
    assert "TC4 at 170 mm is stuck, since 1500 s: left out, check that sensor" in said


def test_values_after_power_on_are_no_start(rod):
    recording, said = reviewed(rod(not_converted_yet))
    assert recording["begun"] == {"at_s": 3.0 * TICK_S, "again": False}
    assert all(recording["channels"][name]["why"] == {"power-on value": 3} for name in ALL)
    assert "all thermometers: 3 x power-on value" in said
    assert recording["temperature_K"]["open_loop"] == pytest.approx(0.051, abs=0.002)


def test_a_run_that_began_with_no_temperatures_is_said_to_have_begun_again(rod):
    recording, said = reviewed(rod(began_elsewhere))
    begun = recording["begun"]
    assert begun["again"]
    assert 3 * TICK_S <= begun["at_s"] <= 60
    assert f"begun again at {begun['at_s']:.0f} s" in said
    assert recording["channels"]["TC1"]["why"] == {"before the start": begun["at_s"] / TICK_S}
    assert recording["temperature_K"]["open_loop"] < 0.08


def test_all_thermometers_that_jump_together_are_said_to_have_other_zeros(rod):
    recording, said = reviewed(rod(another_reference))
    (jump,) = recording["jumps"]
    assert FROM * TICK_S <= jump["at_s"] <= (FROM + 6) * TICK_S
    assert sorted(jump["sizes"]) == ALL
    assert list(jump["sizes"].values()) == pytest.approx([3.0] * 8, abs=0.3)
    assert "all thermometers jumped by" in said
    assert f"K at {jump['at_s']:.0f} s: their zeros are others from then on" in said
