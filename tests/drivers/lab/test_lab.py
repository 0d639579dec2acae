"""Lab CSVs and truth files."""

import time
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from drivers.logs.truth import read_truth
from drivers.recordings import read_recording
from estimator.errors import InputError
from estimator.rig import Rig
from estimator.rig_folder.rig_folder import load_rig
from tests.drivers.lab.conftest import ROD


@pytest.fixture(params=["UTC", "Europe/Berlin", "America/New_York"])
def zone(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Where this machine is."""
    monkeypatch.setenv("TZ", request.param)
    time.tzset()
    yield
    monkeypatch.undo()
    time.tzset()


@pytest.mark.parametrize(
    ("time", "local"),
    [
        (lambda t: t.isoformat(" "), True),
        (lambda t: f"{t.isoformat()}Z", False),
        (lambda t: f"{t.replace(tzinfo=UTC).timestamp() * 1e9:.0f}", False),
        (lambda t: f"{(t - datetime(1899, 12, 30)) / timedelta(days=1):.8f}", True),
        (lambda t: f"{t:%H:%M:%S}", None),
        (lambda t: f"{t:%d-%b-%Y %H:%M:%S}", True),
        (lambda t: f"{t:%d-%b-%Y %H:%M:%S} EST", True),  # letters of a zone, of this machine's own too, are local time
        (lambda t: f"{t:%d-%b-%Y %H:%M:%S} +0000", False),
        (lambda t: f"{t:%Y%m%dT%H%M%S}Z", False),
    ],
)
def test_the_date_of_a_recording(tmp_path: Path, rod: Rig, zone: None, time, local: bool | None) -> None:
    """Where a time says no zone it is the clock on the wall; where it says no day nothing is known."""
    began = datetime(2026, 3, 1, 12)
    cells = [f"{time(began + timedelta(seconds=k))},{20 + k},30,0.1,21,x" for k in range(30)]
    (tmp_path / "a.csv").write_text("\n".join(["t,left,B,P/kW,ambient,remark", *cells, ""]))
    expected = (began if local else began.replace(tzinfo=UTC)).timestamp() if local is not None else None
    assert read_recording(tmp_path / "a.csv", rod).began_s == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize(
    ("years", "other", "rows"), [(27, 3, 30), (-36, 3, 30), (20, 20, 30), (-20, 1, 30), (-20, 20, 40)]
)
def test_a_clock_that_was_set_or_lost_its_date_tells_it_by_most_rows(tmp_path: Path, rod: Rig, years, other, rows):
    """The first `other` rows were stamped years off; of as many the clock was set, for it is seldom put wrong."""
    began = datetime(2026, 3, 1, 12)
    stamps = [began + timedelta(seconds=k) for k in range(rows)]
    off = [stamp.replace(year=2026 + years) if k < other else stamp for k, stamp in enumerate(stamps)]
    (tmp_path / "a.csv").write_text("\n".join(["t,left", *(f"{stamp}Z,{20 + k}" for k, stamp in enumerate(off)), ""]))
    expected = off[0] if 2 * other > rows else began
    told = read_recording(tmp_path / "a.csv", rod).began_s
    assert told == pytest.approx(expected.replace(tzinfo=UTC).timestamp(), abs=1.5)


@pytest.mark.parametrize(("year", "begins"), [("26", 2026), ("99", 1999), ("68", 2068)])
def test_a_year_of_two_digits(tmp_path: Path, rod: Rig, year: str, begins: int) -> None:
    rows = (f"14.03.{year} 12:00:{k:02d}Z,{20 + k}" for k in range(30))
    (tmp_path / "a.csv").write_text("\n".join(["t,left", *rows, ""]))
    assert read_recording(tmp_path / "a.csv", rod).began_s == datetime(begins, 3, 14, 12, tzinfo=UTC).timestamp()


@pytest.mark.parametrize("zero", [datetime(1899, 12, 30), datetime(1, 1, 1)])
def test_days_of_which_the_unit_is_told_are_dates_too(tmp_path: Path, zone: None, zero: datetime) -> None:
    """Of a spreadsheet or of Matlab, and not since 1970."""
    (tmp_path / "rig.toml").write_text(ROD.replace("[log]", '[log]\ncsv = { time_unit = "d" }'))
    began, matlab = datetime(2026, 3, 1, 12), 367 * (zero.year == 1)
    days = [(began - zero + timedelta(seconds=k)) / timedelta(days=1) + matlab for k in range(30)]
    (tmp_path / "a.csv").write_text("\n".join(["t,left", *(f"{day:.8f},{20 + k}" for k, day in enumerate(days)), ""]))
    assert read_recording(tmp_path / "a.csv", load_rig(tmp_path)).began_s == pytest.approx(began.timestamp(), abs=0.01)


def table(path: Path, step: float, rows: int, iso: bool = False) -> Path:
    begin = datetime(2026, 3, 1, 12, tzinfo=UTC)
    times = [begin + timedelta(seconds=k * step) if iso else 100 + k * step for k in range(rows)]
    cells = [f"{t.isoformat() if iso else t},{20 + k},{30 + k},{0.1},21,x" for k, t in enumerate(times)]
    path.write_text("\n".join(["t,left,B,P/kW,ambient,remark", *cells, ""]))
    return path


@pytest.mark.parametrize("iso", [False, True])
def test_a_row_a_tick(tmp_path: Path, rod: Rig, iso: bool) -> None:
    record = read_recording(table(tmp_path / "a.csv", 1.0, 30, iso), rod)
    np.testing.assert_allclose(record.time_s, np.arange(30))
    np.testing.assert_array_equal(record.channels, np.transpose([20 + np.arange(30), 30 + np.arange(30)]))
    np.testing.assert_array_equal(record.inputs["heater"], 100)
    assert (record.omega == 0).all()
    assert record.coverage.shape == (30, rod.screw.cells)
    assert record.skipped == {"column not in the rig file remark": 1}


@pytest.mark.parametrize(("fresh", "kept"), [("left", [0, 3, 4]), ("n", [0, 2, 4])])
def test_a_repeated_value_is_no_reading(tmp_path: Path, fresh: str, kept: list[int]) -> None:
    (tmp_path / "rig.toml").write_text(ROD.replace('column = "left"', f'column = "left", fresh = "{fresh}"'))
    rows = [(0, 20, 1), (1, 20, 1), (2, 20, 2), (3, 21, 2), (4, 20, 3), (5, 20, 3)]
    text = "\n".join(["t,left,n,B", *(f"{t},{left},{n},30" for t, left, n in rows), ""])
    (tmp_path / "a.csv").write_text(text)
    record = read_recording(tmp_path / "a.csv", load_rig(tmp_path))
    assert np.flatnonzero(np.isfinite(record.channels[:, 0])).tolist() == kept
    assert np.isfinite(record.channels[:, 1]).all()


def test_what_should_tell_a_new_reading_and_is_not_there_is_named_and_no_row_is_one(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(ROD.replace('column = "left"', 'column = "left", fresh = "count"'))
    record = read_recording(table(tmp_path / "a.csv", 1.0, 30), load_rig(tmp_path))
    assert not np.isfinite(record.channels[:, 0]).any()
    assert any("no column count" in note for note in record.notes)


def test_faster_rows_give_the_last_of_each_tick(tmp_path: Path, rod: Rig) -> None:
    record = read_recording(table(tmp_path / "a.csv", 0.1, 155), rod)
    np.testing.assert_allclose(np.diff(record.time_s), 1)
    np.testing.assert_allclose(np.diff(record.channels[:, 0]), 10)


def test_slower_rows_leave_ticks_without_measurement(tmp_path: Path, rod: Rig) -> None:
    record = read_recording(table(tmp_path / "a.csv", 10.0, 6), rod)
    np.testing.assert_allclose(record.time_s, np.arange(51))
    np.testing.assert_array_equal(np.flatnonzero(np.isfinite(record.channels[:, 0])), np.arange(0, 51, 10))
    np.testing.assert_array_equal(record.inputs["ambient"], 21)  # an input holds


@pytest.mark.parametrize(("tick_s", "step", "rows"), [(0.5, 0.3, 40), (5.0, 1.0, 40), (5.0, 5.0, 10), (5.0, 0.5, 60)])
def test_rows_and_ticks_of_any_length(tmp_path: Path, rod: Rig, tick_s: float, step: float, rows: int) -> None:
    """Rows at least half a tick apart each close a tick; of faster ones a tick keeps the last."""
    record = read_recording(table(tmp_path / "a.csv", step, rows), replace(rod, tick_s=tick_s))
    assert len(record.notes) == (not 0.5 < step / tick_s < 1.5)
    assert set(record.skipped) <= {"column not in the rig file remark", "after the last whole tick"}
    coarse = step >= tick_s / 2
    np.testing.assert_allclose(np.diff(record.time_s), step if coarse else tick_s)
    np.testing.assert_allclose(np.diff(record.channels[:, 0]), 1 if coarse else tick_s / step)


def test_some_fast_rows_that_are_missing_are_no_silence(tmp_path: Path, rod: Rig) -> None:
    path = table(tmp_path / "a.csv", 0.1, 60)
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join([*lines[:23], *lines[27:]]))
    record = read_recording(path, rod)
    assert record.notes == ("a row each 0.1 s, a tick each 1 s: the last of a tick counts",)
    assert np.isfinite(record.channels).all()


def test_a_gap_of_a_slow_table_is_held_for_a_step_and_a_half(tmp_path: Path, rod: Rig) -> None:
    path = table(tmp_path / "a.csv", 10.0, 12)
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join([*lines[:6], *lines[9:]]))
    record = read_recording(path, replace(rod, tick_s=5.0))
    held = np.isfinite(record.inputs["ambient"])
    np.testing.assert_array_equal(np.flatnonzero(~held), [12, 13, 14, 15])  # rows at 40 s and 80 s, 3 ticks held


def test_what_is_no_number_or_out_of_range(tmp_path: Path, rod: Rig) -> None:
    path = table(tmp_path / "a.csv", 1.0, 10)
    lines = path.read_text().splitlines()
    lines[3] = lines[3].replace(",22,", ",broken,")
    lines[4] = lines[4].replace(",33,", ",999,")
    lines[5] = lines[5].replace(",24,", ",,")
    lines[6] += ",more"
    lines[7] = "soon" + lines[7][3:]
    path.write_text("\n".join([*lines, "110,2"]))
    record = read_recording(path, rod)
    assert record.skipped == {
        "column not in the rig file remark": 1,
        "no number A": 1,
        "out of range B": 1,
        "row with a wrong number of cells": 1,
        "time is no number": 1,
        "torn line": 1,
    }
    assert record.notes == (
        "torn at line 12: it has no line end; read up to there",
        "silent for 3.0 s at 4.000 s (line 9)",
    )
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(record.channels[:, 0])), [2, 4, 5, 6])
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(record.channels[:, 1])), [3, 5, 6])


def test_a_csv_that_is_none(tmp_path: Path, rod: Rig) -> None:
    def complaint(text: str) -> str:
        (tmp_path / "a.csv").write_text(text)
        with pytest.raises(InputError) as error:
            read_recording(tmp_path / "a.csv", rod)
        return str(error.value).removeprefix(f"{tmp_path / 'a.csv'}: ")

    assert complaint("0,20,1\n1,20,1\n").endswith("; its first line holds numbers: write a line of names above it")
    rows = "t,what,value\n" + "".join(f"{k},{name},2{k}\n" for k in range(3) for name in ("left", "ambient"))
    assert complaint(rows).endswith("; a row for each reading, by 'what': write a column for each instead")
    assert complaint("") == "no column of any channel; expected left, B, P/kW, ambient, found empty"
    assert (
        complaint("time,left\n1,2\n")
        == "no time column 't' in the header (time, left); name it in rig.toml as log.time_column"
    )
    assert complaint("t,ambient\n1,2\n") == (
        "no column of any channel; expected left, B, P/kW, ambient, found t, ambient"
    )
    assert complaint("t,left\n") == "0 usable rows: nothing stands below the names"
    expected = "expected seconds, ISO times such as 2026-03-01 12:00:05"
    assert complaint("t,left\nx,1\n").startswith(f"0 usable rows: 'x' in line 2 is no time; {expected}")


def test_truth_beside_a_recording(tmp_path: Path) -> None:
    path = tmp_path / "run.log"
    file = tmp_path / "run.truth.csv"
    assert read_truth(path) is None
    file.write_text("time_s,elongation_um,T01\n0.0,0.0,0.0\n1.0,2.0,0.5\n")
    truth = read_truth(path)
    np.testing.assert_array_equal(truth.at(np.array([0.5, 3.0])), [1.0, np.nan])
    np.testing.assert_array_equal(truth.channels["T01"], [0, 0.5])


def test_truth_at_the_table_is_told_between_its_places_and_never_beyond_them(tmp_path: Path) -> None:
    file, at, times = tmp_path / "run.truth.csv", np.array([0.0, 120.0, 300.0, 301.0]), np.array([0.5, 9.0])
    head = ",".join(f"table_{mm}_um" for mm in (0, 100, 200, 300))
    file.write_text(f"time_s,elongation_um,{head}\n0,0,0,0,0,0\n1,2,0,2,8,18\n")
    truth = read_truth(tmp_path / "run.log")
    np.testing.assert_allclose(truth.at_table(at, times), [[0, 1.44, 9, np.nan], [np.nan] * 4])  # z^2 / 10000, halfway
    assert not truth.channels
    file.write_text("time_s,elongation_um,table_0_um\n0,0,0\n1,2,0\n")
    assert np.isnan(read_truth(tmp_path / "run.log").at_table(at, times)).all()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "cannot be read as a truth file"),
        ("time_s,T01\n0,1\n1,1\n", "no column 'elongation_um'; expected time_s, elongation_um, T01, ..."),
        ("time_s,elongation_um\n0,1\n1\n", "cannot be read as a truth file"),
        ("time_s,elongation_um\n0,1\n1,x\n", "cannot be read as a truth file: could not convert string to float: 'x'"),
        ("time_s,elongation_um\n0,1\n1,nan\n", "expected at least two rows, all of them numbers"),
        ("time_s,elongation_um\n0,1\n2,1\n1,1\n", "time_s must rise (row 4)"),
    ],
)
def test_a_malformed_truth(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "run.truth.csv").write_text(text)
    with pytest.raises(InputError) as error:
        read_truth(tmp_path / "run.log")
    assert str(error.value).startswith(f"{tmp_path / 'run.truth.csv'}: {message}")


@pytest.mark.parametrize(("month", "day", "to", "by"), [(3, 29, "forward", 1), (10, 25, "back", -1)])
@pytest.mark.parametrize("step", [1.0, 5.0, 60.0])
def test_summer_time_begins_and_ends_in_local_stamps(tmp_path: Path, rod: Rig, zone, month, day, to, by, step) -> None:
    """Whatever this machine's own zone is."""
    begin, change = datetime(2026, month, day, 2 + (by < 0)) - timedelta(seconds=30 * step), 30
    stamps = [begin + timedelta(seconds=k * step, hours=by * (k >= change)) for k in range(80)]
    path = tmp_path / "a.csv"
    path.write_text(
        "\n".join(["t,left", *(f"{stamp:%Y-%m-%d %H:%M:%S},{20 + k}" for k, stamp in enumerate(stamps)), ""])
    )
    rig = replace(rod, tick_s=step)
    record = read_recording(path, rig)
    np.testing.assert_allclose(record.time_s, step * np.arange(80))
    assert f"the clock was put {to} an hour at line {change + 2}: no time passes there" in record.notes
    assert len(record.notes) == 2  # no column B


@pytest.mark.parametrize(("hours", "zone", "colder", "goes_on"), [
    (1, "", 0.0, True), (2, "", 0.0, True), (1, "", 0.5, False), (1, "+01:00", 0.0, False),
])  # fmt: skip
def test_a_clock_whose_zone_was_set_by_hand_goes_on(tmp_path: Path, rod: Rig, hours, zone, colder, goes_on) -> None:
    """A thermometer that has changed since shows that the time has really passed."""
    begin = datetime.fromisoformat(f"2026-05-12T10:23:05{zone}")
    stamps = [begin + timedelta(seconds=5 * k, hours=hours * (k >= 40)) for k in range(80)]
    shown = 20 + 0.02 * np.random.default_rng(1).standard_normal(80) - colder * (np.arange(80) >= 40)
    rows = zip(stamps, shown, strict=True)
    (tmp_path / "a.csv").write_text("\n".join(["t,left", *(f"{t.isoformat()},{T:.2f}" for t, T in rows), ""]))
    record = read_recording(tmp_path / "a.csv", replace(rod, tick_s=5.0))
    said = f"put forward {hours} h at line 42, and no thermometer shows it: no time passes there"
    assert (any(said in note for note in record.notes), len(record) >= 79) == (goes_on, goes_on)


def test_an_hour_that_is_missing_otherwise_is_a_silence(tmp_path: Path, rod: Rig) -> None:
    for first, zone in (("01:59:10", "+01:00"), ("01:40:10", "")):
        begin = datetime.fromisoformat(f"2026-03-29T{first}{zone}")
        stamps = [begin + timedelta(seconds=5 * k, hours=k >= 10) for k in range(80)]
        path = tmp_path / "a.csv"
        path.write_text("\n".join(["t,left", *(f"{stamp.isoformat()},20" for stamp in stamps), ""]))
        record = read_recording(path, replace(rod, tick_s=5.0))
        assert any(note.startswith("silent for 1.0 h") for note in record.notes)
