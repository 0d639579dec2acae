"""Lab CSVs as loggers and spreadsheets write them: the same numbers, written in another way, are the same recording."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivers.recordings import read_recording
from estimator.errors import InputError
from estimator.record import Recording
from estimator.rig import Rig, Signal
from estimator.rig_folder.rig_folder import load_rig
from estimator.rig_log import Csv
from tests.drivers.lab.test_lab import rod

__all__ = ["rod"]
NAMES = ["t", "left", "B", "P/kW", "ambient"]
STEP, ROWS = 5.0, 60
Rows = list[list[str]]


@pytest.fixture
def rig(rod: Rig) -> Rig:
    """The rod with a tick as long as its rows are apart."""
    return replace(rod, tick_s=STEP)


def rows(time: Callable[[float], str] = "{:g}".format) -> Rows:
    draw = np.random.default_rng(3)
    values = np.round(draw.uniform(15, 45, (ROWS, 2)), 2)
    return [[time(k * STEP), f"{a:.2f}", f"{b:.2f}", "0.125", "21.5"] for k, (a, b) in enumerate(values)]


def write(path: Path, cells: Rows, names: Sequence[str] = NAMES, sep: str = ",", head: str = "", **how: str) -> Path:
    lines = [sep.join(row) for row in [names, *cells]]
    path.write_text(head + "\n".join(lines) + "\n", **how)
    return path


def clock(form: str, start: str = "2026-03-01 12:00:00") -> Callable[[float], str]:
    return lambda s: (datetime.fromisoformat(start) + timedelta(seconds=s)).strftime(form)


def assert_as_plain(path: Path, rig: Rig, *said: str) -> Recording:
    """The recording is that of the plain CSV, and its notes say these things."""
    record = read_recording(path, rig)
    default = replace(rig, log=replace(rig.log, csv=Csv()))
    plain = read_recording(write(path.with_name("plain.csv"), rows()), default)
    np.testing.assert_allclose(record.time_s, plain.time_s, atol=1e-3)
    np.testing.assert_allclose(record.channels, plain.channels, atol=1e-9)
    np.testing.assert_allclose(record.inputs["heater"], plain.inputs["heater"])
    for words in said:
        assert any(words in note for note in record.notes), record.notes
    return record


def complaint(path: Path, rig: Rig) -> str:
    with pytest.raises(InputError) as error:
        read_recording(path, rig)
    assert "\n" not in str(error.value)
    return str(error.value).removeprefix(f"{path}: ")


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


def test_units_that_are_others(tmp_path: Path, rig: Rig) -> None:
    kelvin = [[r[0], f"{float(r[1]) + 273.15:.2f}", *r[2:]] for r in rows()]
    assert_as_plain(write(tmp_path / "a.csv", kelvin, ["t", "left [K]", *NAMES[2:]]), rig, "A in K")
    assert_as_plain(write(tmp_path / "a.csv", rows(), ["t", "left (K)", *NAMES[2:]]), rig)  # a thermocouple of type K
    said = complaint(write(tmp_path / "a.csv", [["s", "°F", "°C", "kW", "°C"], *rows()]), rig)
    assert said == "column 'left' is in degF, rig.toml has A in degC: convert it there with scale and offset"


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


@pytest.mark.parametrize(
    ("form", "said"),
    [
        ("%Y-%m-%dT%H:%M:%S", ""),
        ("%Y-%m-%d %H:%M:%S.%f", ""),
        ("%Y-%m-%dT%H:%M:%SZ", ""),
        ("%Y/%m/%d %H:%M:%S", ""),
        ("%Y%m%dT%H%M%S", ""),
        ("%d.%m.%Y %H:%M:%S", "day first"),
        ("%d.%m.%y %H:%M:%S", "day first"),
        ("%d.%m.%Y %H:%M:%S,000", "day first"),
        ("%d.%m.%Y - %H:%M:%S", "day first"),
        ("%d/%m/%Y %H:%M:%S", "all of one day"),
        ("%m/%d/%Y %I:%M:%S %p", "all of one day"),
        ("%d-%b-%Y %H:%M:%S", ""),
        ("%b %d, %Y %I:%M:%S %p", ""),
        ("%Y-%m-%d %H:%M:%S CET", ""),
        ("%H:%M:%S", ""),
        ("%I:%M:%S %p", ""),
    ],
)
def test_times_as_text(tmp_path: Path, rig: Rig, form: str, said: str) -> None:
    cells = [[f'"{row[0]}"', *row[1:]] for row in rows(clock(form))]
    assert_as_plain(write(tmp_path / "a.csv", cells), rig, said) if said else assert_as_plain(
        write(tmp_path / "a.csv", cells), rig
    )


@pytest.mark.parametrize("form", ["%d.%m.%Y %H:%M:%S", "%Y-%m-%d %H:%M:%S", "%H:%M:%S", "%d-%b-%Y %I:%M:%S %p"])
def test_over_midnight(tmp_path: Path, rig: Rig, form: str) -> None:
    assert_as_plain(write(tmp_path / "a.csv", rows(clock(form, "2026-02-28 23:58:00"))), rig)
    assert_as_plain(write(tmp_path / "a.csv", rows(clock(form, "2026-02-28 23:58:00"))[::-1]), rig, "newest row first")


@pytest.mark.parametrize("start", ["2026-03-12 23:58:00", "2026-12-31 23:58:00"])
@pytest.mark.parametrize("form", ["%d/%m/%Y %H:%M:%S", "%m/%d/%Y %H:%M:%S", "%d-%m-%Y %H:%M:%S"])
def test_the_order_of_day_and_month_by_days_that_are_no_month(tmp_path: Path, rig: Rig, form: str, start: str) -> None:
    assert_as_plain(write(tmp_path / "a.csv", rows(clock(form, start))), rig)


def test_an_order_that_is_open_is_refused_until_rig_toml_says(tmp_path: Path, rig: Rig) -> None:
    path = write(tmp_path / "a.csv", rows(clock("%d/%m/%Y %H:%M:%S", "2026-03-01 23:58:00")))
    said = complaint(path, rig)
    assert "line 2: in '01/03/2026 23:58:00' day or month may come first: say time_format = " in said
    assert '"%d/%m/%Y %H:%M:%S" or "%m/%d/%Y %H:%M:%S"' in said
    assert_as_plain(path, replace(rig, log=replace(rig.log, csv=Csv(time_format="%d/%m/%Y %H:%M:%S"))))


@pytest.mark.parametrize("names", [["Date", "Time"], ["Datum", "Uhrzeit"], ["t", "when"], ["day", "t"]])
@pytest.mark.parametrize("form", ["%Y-%m-%d|%H:%M:%S", "%d.%m.%Y|%H:%M:%S", "%m/%d/%Y|%I:%M:%S %p"])
def test_date_and_time_of_day_in_two_columns(tmp_path: Path, rig: Rig, names: list[str], form: str) -> None:
    cells = [[*row[0].split("|"), *row[1:]] for row in rows(clock(form, "2026-03-13 23:58:00"))]
    assert_as_plain(write(tmp_path / "a.csv", cells, [*names, *NAMES[1:]]), rig)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (lambda s: f"{s * 1e3:.0f}", "milliseconds"),
        (lambda s: f"{s * 1e6:.0f}", "microseconds"),
        (lambda s: f"{s * 1e9:.0f}", "nanoseconds"),
        (lambda s: f"{s / 60:.4f}", "minutes"),
        (lambda s: f"{s / 60:.2f}", "minutes"),
        (lambda s: f"{s / 3600:.6f}", "hours"),
        (lambda s: f"{46082.5 + s / 86400:.8f}", "days of a spreadsheet"),
        (lambda s: f"{1_770_000_000 + s:.0f}", ""),
        (lambda s: f"{(1_770_000_000 + s) * 1000:.0f}", "milliseconds since 1970"),
        (lambda s: f"{1_770_000_000_000_000 + int(s * 1e6)}", "microseconds since 1970"),
        (lambda s: f"{1_770_000_000_000_000_000 + int(s * 1e9)}", "nanoseconds since 1970"),
    ],
)
def test_times_as_numbers(tmp_path: Path, rig: Rig, text: Callable[[float], str], said: str) -> None:
    record = read_recording(write(tmp_path / "a.csv", rows(text)), rig)
    np.testing.assert_allclose(record.time_s, np.arange(ROWS) * STEP, atol=0.4)
    assert any(said in note for note in record.notes) or not said


def test_a_unit_of_times_that_is_said(tmp_path: Path, rig: Rig) -> None:
    fast = rows(lambda s: f"{s * 200:g}")  # rows of 1 s in ms where the tick is 5 s
    assert "milliseconds or seconds? say time_unit" in complaint(write(tmp_path / "a.csv", fast), rig)
    for names, csv in ((["t (ms)"], Csv()), (["t"], Csv(time_unit="ms"))):
        path = write(tmp_path / "a.csv", fast, [*names, *NAMES[1:]])
        record = read_recording(path, replace(rig, log=replace(rig.log, csv=csv)))
        assert record.time_s[-1] == pytest.approx(ROWS, abs=5)
    whole = rows(lambda s: f"{s / 5:g}")
    minute = replace(rig, tick_s=60.0)
    assert "minutes or seconds? say time_unit" in complaint(write(tmp_path / "a.csv", whole), minute)


def test_rows_out_of_order(tmp_path: Path, rig: Rig) -> None:
    plain = rows()
    assert_as_plain(write(tmp_path / "a.csv", plain[::-1]), rig, "newest row first, turned round")
    assert_as_plain(
        write(tmp_path / "a.csv", [*plain[40:], *plain[:40]]), rig, "rows sorted by time: it went back 1 times"
    )
    late = [*plain[:20], *plain[21:24], plain[20], *plain[24:]]
    assert_as_plain(write(tmp_path / "a.csv", late), rig, "rows sorted by time")


def test_parts_that_overlap_are_told_once(tmp_path: Path, rig: Rig) -> None:
    plain = rows()
    assert_as_plain(write(tmp_path / "a.csv", [*plain[:40], *plain[30:]]), rig, "10 rows are there twice")
    assert_as_plain(write(tmp_path / "a.csv", [*plain[30:], *plain[:40]]), rig, "10 rows are there twice")


def test_a_clock_that_was_set_back_is_no_matter_of_order(tmp_path: Path, rig: Rig) -> None:
    record = read_recording(write(tmp_path / "a.csv", rows(lambda s: f"{s - 62 * (s > 150):g}")), rig)
    assert any("clock jumps back" in note for note in record.notes)
    assert not any("sorted" in note for note in record.notes)


@pytest.mark.parametrize("resolution", [10, 15, 60])
@pytest.mark.parametrize("start", [0, 20])
def test_several_rows_of_one_time(tmp_path: Path, rig: Rig, resolution: int, start: int) -> None:
    cells = rows(lambda s: f"{(s + start) // resolution * resolution:g}")
    assert_as_plain(write(tmp_path / "a.csv", cells), rig, "rows share a time")
    assert_as_plain(write(tmp_path / "a.csv", cells[::-1]), rig, "rows share a time")


def test_rows_that_are_written_twice_or_in_parts_are_one(tmp_path: Path, rig: Rig) -> None:
    twice = [row for row in rows() for _ in range(2)]
    assert_as_plain(write(tmp_path / "a.csv", twice), rig, "taken together")
    parts = [part for r in rows() for part in ([r[0], r[1], "", r[3], ""], [r[0], "", r[2], "", r[4]])]
    assert_as_plain(write(tmp_path / "a.csv", parts), rig, "taken together")


@pytest.mark.parametrize("catches_up", [False, True])
def test_a_clock_that_stands_still(tmp_path: Path, rig: Rig, catches_up: bool) -> None:
    def text(s: float) -> str:
        return f"{100 if 100 <= s < 150 else s - (0 if catches_up or s < 150 else 45):g}"

    assert_as_plain(write(tmp_path / "a.csv", rows(text)), rig, *([] if catches_up else ["time stands still"]))
    said = complaint(write(tmp_path / "a.csv", rows(lambda s: "7")), rig)
    assert said.startswith("time stands still: all 60 rows have the same")


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)
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


def test_a_rig_file_may_have_temperatures_in_kelvin(tmp_path: Path, rod: Rig) -> None:
    text = (tmp_path / "rig.toml").read_text()
    (tmp_path / "rig.toml").write_text(text.replace("hi = 90", 'unit = "K", lo = 283.15, hi = 363.15'))
    kelvin = replace(load_rig(tmp_path), tick_s=STEP)
    assert (kelvin.channels["B"].lo, kelvin.channels["B"].hi) == pytest.approx((10.0, 90.0))
    cells = [[*r[:2], f"{float(r[2]) + 273.15:.2f}", *r[3:]] for r in rows()]
    record = read_recording(write(tmp_path / "a.csv", cells), kelvin)
    np.testing.assert_allclose(record.channels[:, 1], [float(row[2]) for row in rows()])


@pytest.mark.parametrize(("form", "said"), [("%M:%S", "minutes and seconds"), ("%H:%M", "rows share a time")])
def test_times_of_two_numbers(tmp_path: Path, rig: Rig, form: str, said: str) -> None:
    assert_as_plain(write(tmp_path / "a.csv", rows(clock(form, "2026-03-01 23:58:00"))), rig, said)


def test_times_of_two_numbers_that_may_be_either_are_refused(tmp_path: Path, rig: Rig) -> None:
    path = write(tmp_path / "a.csv", rows(clock("%M:%S", "2026-03-01 23:58:00")))
    said = complaint(path, replace(rig, tick_s=1.0))
    assert said.startswith('line 2: \'58:00\' is of hours or of minutes? Say time_format = "%H:%M" or "%M:%S"')
    assert_as_plain(path, replace(rig, log=replace(rig.log, csv=Csv(time_format="%M:%S"))))


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


def test_signs_before_blanks(tmp_path: Path, rig: Rig) -> None:
    assert_as_plain(write(tmp_path / "a.csv", [[r[0], *(f"+ {c}" for c in r[1:])] for r in rows()]), rig)


@pytest.mark.parametrize("commas", [range(1), range(1, 5)])
def test_times_with_another_decimal_mark_than_the_values(tmp_path: Path, rig: Rig, commas: range) -> None:
    cells = [
        [cell.replace(".", ",") if k in commas else cell for k, cell in enumerate(row)] for row in rows("{:.1f}".format)
    ]
    assert_as_plain(write(tmp_path / "a.csv", cells, sep=";"), rig)


@pytest.mark.parametrize("per_s", [1, 1000, 1 / 60])
@pytest.mark.parametrize("period", [86400, 604800, 43200, 2**16, 2**32 / 1e6, 2**32 / 1e3])
def test_times_that_begin_again_go_on(tmp_path: Path, rig: Rig, per_s: float, period: float) -> None:
    cells = rows(lambda s: f"{(period - 100 + s) % period * per_s:.6f}")
    said = f"times begin again after {period:.10g} s"
    assert_as_plain(write(tmp_path / "a.csv", cells), rig, said)
    assert_as_plain(write(tmp_path / "a.csv", cells[::-1]), rig, said, "newest row first")


def test_a_clock_of_twelve_hours_that_does_not_say_which(tmp_path: Path, rig: Rig) -> None:
    for form in ("%I:%M:%S", "%d.%m.%Y %I:%M:%S"):
        cells = rows(clock(form, "2026-03-13 12:58:00"))
        assert_as_plain(write(tmp_path / "a.csv", cells), rig, "times begin again after 43200 s")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (lambda s: f"{740_000.5 + s / 86400:.9f}", "days since the year 0"),
        (lambda s: f"{134_200_000_000_000_000 + int(s * 1e7)}", "100 ns since 1601"),
        (lambda s: f"{639_000_000_000_000_000 + int(s * 1e7)}", "100 ns since the year 1"),
    ],
)
def test_times_that_other_programs_count(tmp_path: Path, rig: Rig, text: Callable[[float], str], said: str) -> None:
    record = read_recording(write(tmp_path / "a.csv", rows(text)), rig)
    np.testing.assert_allclose(record.time_s, np.arange(ROWS) * STEP, atol=0.1)
    assert any(said in note for note in record.notes)


@pytest.mark.parametrize("lost", ["1970-01-01", "2000-01-01"])
@pytest.mark.parametrize("first", [True, False])
def test_a_clock_that_loses_its_date_or_finds_it(tmp_path: Path, rig: Rig, lost: str, first: bool) -> None:
    form = "%Y-%m-%d %H:%M:%S"
    good, bad = rows(clock(form)), rows(clock(form, f"{lost} 00:00:00"))
    cells = [*bad[:20], *good[20:]] if first else [*good[:20], *bad[20:]]
    assert_as_plain(write(tmp_path / "a.csv", cells), rig, "clock jumps")


def test_a_logger_that_began_again_is_not_sorted_in(tmp_path: Path, rig: Rig) -> None:
    cells = rows(lambda s: f"{s if s < 150 else s - 147.5:g}")  # half a step from the rows before
    assert_as_plain(write(tmp_path / "a.csv", cells), rig, "clock jumps back")


@pytest.mark.parametrize(
    "form",
    [
        "Fr %d.%m.%Y %H:%M:%S",
        "'%d.%m.%Y %H:%M:%S'",
        "%Y%m%d-%H%M%S",
        "0 days %H:%M:%S",
        "%d.%m.%Y, %H:%M:%S Uhr",
        "[%Y-%m-%d %H:%M:%S]",
    ],
)
def test_more_times_as_text(tmp_path: Path, rig: Rig, form: str) -> None:
    assert_as_plain(write(tmp_path / "a.csv", rows(clock(form, "2026-03-13 12:00:00")), sep=";"), rig)


def test_a_date_that_is_written_where_it_changes(tmp_path: Path, rig: Rig) -> None:
    cells = [row[0].split("|") + row[1:] for row in rows(clock("%d.%m.%y|%H:%M:%S", "2026-03-13 23:58:00"))]
    for k, row in enumerate(cells):
        row[0] = row[0] if k in (0, 24) else ""
    assert_as_plain(write(tmp_path / "a.csv", cells, ["DATUM:", "ZEIT:", *NAMES[1:]], sep=";"), rig)


def test_times_that_lost_their_digits_are_refused(tmp_path: Path, rig: Rig) -> None:
    cells = rows(lambda s: f"{1.7734032e12 + s * 1000:.7E}")
    said = complaint(write(tmp_path / "a.csv", cells), rig)
    assert said.startswith("times have a resolution of 100 s, several rows share each: digits were lost")


def test_tenths_of_a_degree_are_told(tmp_path: Path, rig: Rig) -> None:
    wide = {name: replace(rig.channels[name], hi=200.0) for name in "AB"}
    cells = [[row[0], *(f"{10 * float(c):.0f}" for c in row[1:3]), *row[3:]] for row in rows()]
    said = complaint(write(tmp_path / "a.csv", cells), replace(rig, channels={**rig.channels, **wide}))
    assert said.startswith("most thermometers are too hot: A has ")
    assert "in tenths of a degree? Say scale = 0.1" in said


def test_a_name_over_two_lines_is_told_in_one(tmp_path: Path, rig: Rig) -> None:
    path = write(tmp_path / "a.csv", rows(), [*NAMES[:4], '"ambient\n[°C]"'])
    assert_as_plain(path, rig, "'ambient [°C]' as ambient")


@pytest.mark.parametrize("mark", [".", ","])
def test_minutes_and_seconds_as_excel_saves_them(tmp_path: Path, rig: Rig, mark: str) -> None:
    cells = rows(clock("%M:%S" + mark + "0", "2026-03-13 12:58:00"))
    assert_as_plain(write(tmp_path / "a.csv", cells, sep=";"), rig, "the clock was put back an hour at line 26")


def test_names_that_stand_again_in_the_middle(tmp_path: Path, rig: Rig) -> None:
    plain = rows()
    record = assert_as_plain(write(tmp_path / "a.csv", [*plain[:20], NAMES, *plain[20:]]), rig)
    assert record.skipped == {"line of names, again": 1}
    for names in ([*NAMES[:1], *NAMES[2:0:-1], *NAMES[3:]], [*NAMES, "C"]):
        path = write(tmp_path / "a.csv", [*plain[:20], names, *plain[20:]])
        assert complaint(path, rig) == "line 22 has other names than line 1: split the file there"


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
    notes = read_recording(write(tmp_path / "a.csv", cells, names), replace(rig, channels=wide)).notes
    assert any(note.startswith("all thermometers begin at 72 degC or more: in degF?") for note in notes)
    warm = [[r[0], *("61.6", "91.8"), *r[3:], "71.7"] for r in rows()]
    notes = read_recording(write(tmp_path / "a.csv", warm, names), replace(rig, channels=wide)).notes
    assert not any("degF" in note for note in notes)
