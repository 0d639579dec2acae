"""Units in names, in cells and in lines of their own: what is read in another is converted, or said."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.recordings import read_recording
from estimator.rig import Rig, Signal
from estimator.rig_folder.rig_folder import load_rig
from tests.drivers.lab.conftest import NAMES, ROD, ROWS, STEP, assert_as_plain, complaint, rows, write


def test_units_that_are_others(tmp_path: Path, rig: Rig) -> None:
    kelvin = [[r[0], f"{float(r[1]) + 273.15:.2f}", *r[2:]] for r in rows()]
    assert_as_plain(write(tmp_path / "a.csv", kelvin, ["t", "left [K]", *NAMES[2:]]), rig, "A in K")
    assert_as_plain(write(tmp_path / "a.csv", rows(), ["t", "left (K)", *NAMES[2:]]), rig)  # a thermocouple of type K
    said = complaint(write(tmp_path / "a.csv", [["s", "°F", "°C", "kW", "°C"], *rows()]), rig)
    assert said == "column 'left' is in degF, rig.toml has A in degC: convert it there with scale and offset"


def test_a_rig_file_may_have_temperatures_in_kelvin(tmp_path: Path, rod: Rig) -> None:
    text = (tmp_path / "rig.toml").read_text()
    (tmp_path / "rig.toml").write_text(text.replace("hi = 90", 'unit = "K", lo = 283.15, hi = 363.15'))
    kelvin = replace(load_rig(tmp_path), tick_s=STEP)
    assert (kelvin.channels["B"].lo, kelvin.channels["B"].hi) == pytest.approx((10.0, 90.0))
    cells = [[*r[:2], f"{float(r[2]) + 273.15:.2f}", *r[3:]] for r in rows()]
    record = read_recording(write(tmp_path / "a.csv", cells), kelvin)
    np.testing.assert_allclose(record.channels[:, 1], [float(row[2]) for row in rows()])


def test_temperatures_in_another_unit_are_said(tmp_path: Path, rig: Rig) -> None:
    def converted(change: Callable[[float], float]) -> Path:
        cells = [
            [r[0], *(f"{change(float(c)):.2f}" for c in r[1:3]), r[3], f"{change(float(r[4])):.2f}"] for r in rows()
        ]
        return write(tmp_path / "a.csv", cells)

    said = complaint(converted(lambda c: c + 273.15), rig)
    assert re.fullmatch(r"no thermometer was ever read: A has .* outside -60 ... 200 degC; in K\? Say unit = .*", said)
    wide = replace(rig, channels={**rig.channels, "B": replace(rig.channels["B"], hi=200.0)})
    hot = read_recording(converted(lambda c: 1.8 * c + 32), wide)
    assert any("all temperatures begin at" in note and "in degF?" in note for note in hot.notes)
    cells = [[row[0], f"{row[1]} ohm", f"{row[2]} ohm", *row[3:]] for row in rows()]
    said = complaint(write(tmp_path / "a.csv", cells), rig)
    assert said == f"no thermometer was ever read: A is '{rows()[0][1]} ohm' in line 2, no number"


def test_values_after_power_on_are_in_no_other_unit(tmp_path, rig):
    wide = replace(rig, channels={name: replace(channel, hi=200.0) for name, channel in rig.channels.items()})
    cells = [[r[0], "85.00", "85.00", r[3], "85.00"] if n < 2 else r for n, r in enumerate(rows())]
    assert not any("degF" in note for note in read_recording(write(tmp_path / "a.csv", cells), wide).notes)


def test_a_column_of_another_unit_that_rig_toml_calls_the_times_counts_seconds(tmp_path, rig):
    rig = replace(rig, log=replace(rig.log, time_column="Weg [mm]"))
    record = read_recording(write(tmp_path / "a.csv", rows(), ["Weg [mm]", *NAMES[1:]]), rig)
    assert len(record) == ROWS


@pytest.mark.parametrize("unit", [" °C", " / °C", "/°C", " in °C", ", degC", " [Â°C]", " <101> (C)"])
def test_units_that_stand_in_names(tmp_path: Path, rig: Rig, unit: str) -> None:
    names = ["t", f"left{unit}", f"B{unit}", *NAMES[3:]]
    assert_as_plain(write(tmp_path / "a.csv", rows(), names, sep=";"), rig)
    other = [name.replace("C", "F") for name in names[:2]]
    if "Â" not in unit:
        said = complaint(write(tmp_path / "a.csv", rows(), [*other, *names[2:]], sep=";"), rig)
        assert said.endswith("is in degF, rig.toml has A in degC: convert it there with scale and offset")


def test_a_name_whose_end_only_looks_like_a_unit_is_another_name(tmp_path: Path, rig: Rig) -> None:
    cells = [[*row, "3", "99"] for row in rows()]
    assert_as_plain(write(tmp_path / "a.csv", cells, [*NAMES, "left min", "left c"]), rig)


@pytest.mark.parametrize(
    ("unit", "said"),
    [("mm/min", "mm/min"), ("Hz", "1/s"), ("1/s", "1/s"), ("m/min", "m/min"), ("rad/s", "rad/s"), ("1/min", "")],
)
def test_a_speed_in_another_unit_is_refused(tmp_path: Path, rig: Rig, unit: str, said: str) -> None:
    rig = replace(rig, inputs={**rig.inputs, "speed": Signal(unit="rpm", lo=-100.0, column="n")})
    path = write(tmp_path / "a.csv", [[*row, "8"] for row in rows()], [*NAMES, f"n [{unit}]"])
    if said:
        assert complaint(path, rig).startswith(f"column 'n [{unit}]' is in {said}, rig.toml has speed in rpm: ")
    else:
        assert_as_plain(path, rig)


def test_units_that_stand_in_cells(tmp_path: Path, rig: Rig) -> None:
    cells = [[f"{row[0]} s", f"{row[1]} °C", f"{row[2]}°C", row[3], f"{row[4]} °C"] for row in rows()]
    cells[7][1] = "open"
    cells[8][1] = "71.8 °F"
    record = read_recording(write(tmp_path / "a.csv", cells), rig)
    assert record.skipped["no number A"] == 2
    np.testing.assert_allclose(record.channels[:, 1], [float(row[2]) for row in rows()])
    fahrenheit = [[row[0], f"{row[1]} °F", *row[2:]] for row in rows()]
    assert "column 'left' is in degF" in complaint(write(tmp_path / "a.csv", fahrenheit), rig)


def test_tenths_of_a_degree_are_told(tmp_path: Path, rig: Rig) -> None:
    wide = {name: replace(rig.channels[name], hi=200.0) for name in "AB"}
    cells = [[row[0], *(f"{10 * float(c):.0f}" for c in row[1:3]), *row[3:]] for row in rows()]
    said = complaint(write(tmp_path / "a.csv", cells), replace(rig, channels={**rig.channels, **wide}))
    assert said.startswith("most thermometers are too hot: A has ")
    assert "in tenths of a degree? Say scale = 0.1" in said
    kelvin = [[row[0], *(f"{float(c) + 273.15:.2f}" for c in row[1:3]), *row[3:]] for row in rows()]
    assert 'in K? Say unit = "K". Or in tenths of a degree' in complaint(write(tmp_path / "a.csv", kelvin), rig)


@pytest.mark.parametrize("encoding", ["cp850", "mac-roman"])
def test_degrees_of_other_encodings(tmp_path: Path, rig: Rig, encoding: str) -> None:
    for unit in "CF":
        path = write(tmp_path / "a.csv", rows(), ["t", f"left [°{unit}]", *NAMES[2:]], encoding=encoding)
        if unit == "C":
            assert_as_plain(path, rig)
        else:
            assert "is in degF" in complaint(path, rig)


def test_thermometers_alone_in_degrees_fahrenheit_are_asked_about(tmp_path: Path, rig: Rig) -> None:
    names = [*NAMES, "C"]
    wide = {name: replace(rig.channels["B"], column=name, hi=200.0) for name in ("left", "B", "C")}
    cells = [[r[0], *("71.6", "71.8"), *r[3:], "71.7"] for r in rows()]
    record = read_recording(write(tmp_path / "a.csv", cells, names, ";"), replace(rig, channels=wide))
    assert record.notes[0].startswith("all thermometers begin at 72 degC or more: in degF?")
    assert record.notes[1:] == ("';' between cells",)
    assert record.doubts == record.notes[:1]
    warm = [[r[0], *("61.6", "91.8"), *r[3:], "71.7"] for r in rows()]
    notes = read_recording(write(tmp_path / "a.csv", warm, names), replace(rig, channels=wide)).notes
    assert not any("degF" in note for note in notes)


@pytest.mark.parametrize(("words", "unit", "read"), [
    (("True", "FALSE", "true"), "1", [1.0, 0.0, 1.0]), (("ein", "", "aus"), "1", [1.0, np.nan, 0.0]),
    (("on", "off", "0.5"), "1", [np.nan, np.nan, 0.5]), (("on", "off", "on"), "degC", [np.nan] * 3),
    (("off", "on", "off"), "W", [np.nan] * 3),
])  # fmt: skip
def test_a_column_of_on_and_off_is_1_and_0_but_no_temperature(tmp_path, words, unit, read):
    (tmp_path / "rig.toml").write_text(ROD + f'switch = {{ unit = "{unit}", lo = 0.0, hi = 100.0 }}\n')
    rows = [f"{t},20.{t},30,{word}" for t, word in enumerate(words)]
    (tmp_path / "a.csv").write_text("\n".join(["t,left,B,switch", *rows, ""]))
    record = read_recording(tmp_path / "a.csv", load_rig(tmp_path))
    np.testing.assert_array_equal(record.inputs["switch"], read)
    hint = f"switch is '{words[0]}' in line 2, no number; an input that is on or off has unit = \"1\" in rig.toml"
    assert (hint in record.notes) == (unit != "1")
    assert any("switch on and off as 1 and 0" in note for note in record.notes) == (unit == "1" and words[2] != "0.5")
