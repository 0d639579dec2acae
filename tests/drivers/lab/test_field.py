"""Lab CSVs as loggers and spreadsheets write them: the same numbers, written in another way, are the same recording."""

from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from drivers.recordings import read_recording
from estimator.rig import Rig
from estimator.rig_log import Csv
from tests.drivers.lab.conftest import NAMES, assert_as_plain, clock, complaint, rows, write


@pytest.mark.parametrize("sep", [",", ";", "\t", "|", " "])
@pytest.mark.parametrize("comma", [False, True])
@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252"])
def test_separators_decimal_marks_and_encodings(tmp_path: Path, rig: Rig, sep: str, comma: bool, encoding: str) -> None:
    cells = [[cell.replace(".", "," if comma else ".") for cell in row] + ["°C"] for row in rows()]
    if comma and sep == ",":
        cells = [[f'"{cell}"' for cell in row] for row in cells]
    path = write(tmp_path / "a.csv", cells, [*NAMES, "remark"], sep, encoding=encoding, newline="\r\n")
    assert_as_plain(path, rig, *(["',' as decimal mark"] if comma else []), *(["between cells"] if sep != "," else []))


def test_a_comma_between_cells_and_in_numbers_without_quotes(tmp_path: Path, rig: Rig) -> None:
    cells = [[cell.replace(".", ",") for cell in row] for row in rows()]
    said = complaint(write(tmp_path / "a.csv", cells), rig)
    assert said.startswith(
        "5 names but 9 cells in a row: with commas in numbers, cells need another separator or quote"
    )


@pytest.mark.parametrize(
    ("cell", "decimal", "value"),
    [
        ("1.234,50", ",", 1234.5),
        ("1,234.50", ".", 1234.5),
        ("1234,5", ",", 1234.5),
        ("0,125", ",", 0.125),
        ("1 234,5", ",", 1234.5),
        ("1'234.5", ".", 1234.5),
    ],
)
def test_marks_between_thousands(tmp_path: Path, rig: Rig, cell: str, decimal: str, value: float) -> None:
    heater = replace(rig.inputs["heater"], unit="kW", scale=1.0, hi=1e6)
    rig = replace(rig, inputs={**rig.inputs, "heater": heater})
    cells = [
        [f'"{c}"' for c in [r[0], r[1].replace(".", decimal), r[2].replace(".", decimal), cell, "21"]] for r in rows()
    ]
    record = read_recording(write(tmp_path / "a.csv", cells), rig)
    np.testing.assert_allclose(record.inputs["heater"], value)


def test_commas_that_may_be_either_are_refused_until_rig_toml_says(tmp_path: Path, rig: Rig) -> None:
    cells = [[f'"{c}"' for c in (row[0], "22,125", "23,250", "1", "21")] for row in rows()]
    path = write(tmp_path / "a.csv", cells)
    assert complaint(path, rig).startswith("is '22,125' 22125 or 22.125? say decimal = ")
    record = read_recording(path, replace(rig, log=replace(rig.log, csv=Csv(decimal=","))))
    np.testing.assert_allclose(record.channels[:, 0], 22.125)


@pytest.mark.parametrize("head", ["", "Logger;GX-20\nSerial;000123\n\n", "sep=;\n", "# made by TC logger\n" * 40])
@pytest.mark.parametrize(
    "units", [None, ["s", "°C", "degC", "kW", "C"], ["", "", "", "", ""], ["[s]", "x", "x", "-", ""]]
)
def test_lines_before_the_names_and_below_them(tmp_path: Path, rig: Rig, head: str, units: list[str] | None) -> None:
    path = write(tmp_path / "a.csv", [*([units] if units else []), *rows()], sep=";", head=head)
    lines = head.count("\n")
    assert_as_plain(path, rig, *([f"names in line {lines + 1}"] if lines else []))
    assert_as_plain(path, replace(rig, log=replace(rig.log, csv=Csv(skip=lines))))


@pytest.mark.parametrize("end", [",", ",,,"])
def test_separators_behind_the_last_cell(tmp_path: Path, rig: Rig, end: str) -> None:
    cells = [[*row[:-1], row[-1] + end] for row in rows()]
    assert_as_plain(write(tmp_path / "a.csv", cells), rig)
    assert_as_plain(write(tmp_path / "b.csv", cells, [*NAMES[:-1], NAMES[-1] + end]), rig)


def test_names_that_are_nearly_right_doubled_or_not_there(tmp_path: Path, rig: Rig) -> None:
    assert_as_plain(write(tmp_path / "a.csv", rows(), ["T", "Left (°C)", "b", "P/kW", "Ambient"]), rig, "'b' as B")
    record = read_recording(write(tmp_path / "a.csv", rows(), ["t", "left", "B2", "P/kW", "ambient"]), rig)
    assert "no column B (there is 'B2'): not measured" in record.notes
    record = read_recording(write(tmp_path / "a.csv", rows(), ["t", "left", "B", "P/kW", "ambience"]), rig)
    assert "no column ambient (there is 'ambience'): not measured" in record.notes
    said = complaint(write(tmp_path / "a.csv", rows(), ["t", "left", "left", "P/kW", "ambient"]), rig)
    assert said == "'left' stands in columns 2 and 3: rename all but the one that rig.toml means"
    said = complaint(write(tmp_path / "a.csv", rows(), ["t", "Left", "LEFT", "P/kW", "ambient"]), rig)
    assert said == "'Left' and 'LEFT' could both be 'left': rename all but the one that rig.toml means"
    said = complaint(write(tmp_path / "a.csv", rows(), ["time", *NAMES[1:]]), rig)
    assert "no time column 't' in the header (time, left, B, P/kW, ambient)" in said


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
@given(
    sep=st.sampled_from([";", "\t", "|"]), comma=st.booleans(), head=st.integers(0, 5), units=st.booleans(),
    form=st.sampled_from(["%d.%m.%Y %H:%M:%S", "%Y-%m-%d %H:%M:%S", "%d-%b-%Y %H:%M:%S"]), end=st.booleans(),
    newest=st.booleans(), start=st.datetimes(datetime(2001, 1, 1), datetime(2099, 1, 1)),
)  # fmt: skip
def test_all_of_it_together(tmp_path: Path, rig: Rig, sep, comma, head, units, form, end, newest, start) -> None:
    start = start.replace(hour=23, minute=57, microsecond=0)  # over midnight, away from summer time
    cells = [
        [row[0], *(c.replace(".", "," if comma else ".") for c in row[1:])] for row in rows(clock(form, str(start)))
    ]
    cells = cells[::-1] if newest else cells
    cells = [[*row, *[""] * end] for row in [*([["", "°C", "°C", "kW", "°C"]] if units else []), *cells]]
    assert_as_plain(write(tmp_path / "a.csv", cells, sep=sep, head="logger 7\n" * head), rig)


def test_signs_before_blanks(tmp_path: Path, rig: Rig) -> None:
    assert_as_plain(write(tmp_path / "a.csv", [[r[0], *(f"+ {c}" for c in r[1:])] for r in rows()]), rig)


def test_a_name_over_two_lines_is_told_in_one(tmp_path: Path, rig: Rig) -> None:
    path = write(tmp_path / "a.csv", rows(), [*NAMES[:4], '"ambient\n[°C]"'])
    assert_as_plain(path, rig, "'ambient [°C]' as ambient")


def test_names_that_stand_again_in_the_middle(tmp_path: Path, rig: Rig) -> None:
    plain = rows()
    record = assert_as_plain(write(tmp_path / "a.csv", [*plain[:20], NAMES, *plain[20:]]), rig)
    assert record.skipped == {"line of names, again": 1}
    for names in ([*NAMES[:1], *NAMES[2:0:-1], *NAMES[3:]], [*NAMES, "C"]):
        path = write(tmp_path / "a.csv", [*plain[:20], names, *plain[20:]])
        assert complaint(path, rig) == "line 22 has other names than line 1: split the file there"


def test_the_comments_of_labview_may_be_left_out(tmp_path: Path, rig: Rig) -> None:
    """As in a .lvm that was renamed: a head of its own, tabs, a last column that most rows do not have."""
    head = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\nDelta_X\t5\t5\n***End_of_Header***\t\n"
    cells = [row + (["began"] if k == 0 else []) for k, row in enumerate(rows())]
    path = write(tmp_path / "a.csv", cells, [*NAMES, "Comment"], "\t", head=head)
    assert_as_plain(path, rig, "tabs between cells", "names in line 7")


def test_names_that_are_others_are_shown_as_they_are_separated(tmp_path: Path, rig: Rig) -> None:
    names = ["Time", "left Ave. (°C)", "right Ave. (°C)", "power Ave. (W)", "air Ave. (°C)"]
    said = complaint(write(tmp_path / "a.csv", rows(), names), rig)
    assert said.startswith(
        "no column of any channel; expected left, B, P/kW, ambient, found Time, left Ave. (°C), right"
    )


def test_a_column_of_times_before_each_signal(tmp_path: Path, rig: Rig) -> None:
    """As TwinCAT's Scope exports them; where they are not alike none can stand for all."""
    rig = replace(rig, log=replace(rig.log, time_column="Name"))
    head = "Name;Scope\nFile;x.svdx\n\n"
    names = [word for name in NAMES[1:] for word in ("Name", name)]
    cells = [[word for cell in row[1:] for word in (f"{float(row[0]) * 1000:.0f}", cell)] for row in rows()]
    path = write(tmp_path / "a.csv", [["SampleTime[ms]", "5000"] * 4, *cells], names, ";", head=head)
    record = read_recording(path, rig)
    plain = read_recording(write(tmp_path / "plain.csv", rows(), ["Name", *NAMES[1:]]), rig)
    np.testing.assert_allclose(record.channels, plain.channels)
    assert "the first of 4 columns 'Name', which are alike" in record.notes[0]
    cells[5][2] = "25001"
    assert complaint(write(path, cells, names, ";"), rig).startswith("'Name' stands in columns 1 and 3 and 5 and 7:")
