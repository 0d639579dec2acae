"""Times as loggers and spreadsheets write them: as text, as numbers, in two columns."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.recordings import read_recording
from estimator.rig import Rig
from estimator.rig_log import Csv
from tests.drivers.lab.conftest import NAMES, ROWS, STEP, assert_as_plain, clock, complaint, rows, write


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
        (lambda s: f"{740_000.5 + s / 86400:.9f}", "days since the year 0"),
        (lambda s: f"{134_200_000_000_000_000 + int(s * 1e7)}", "100 ns since 1601"),
        (lambda s: f"{639_000_000_000_000_000 + int(s * 1e7)}", "100 ns since the year 1"),
    ],
)
def test_times_as_numbers(tmp_path: Path, rig: Rig, text: Callable[[float], str], said: str) -> None:
    record = read_recording(write(tmp_path / "a.csv", rows(text)), rig)
    within_s = 0.4 if said == "minutes" else 0.1  # two digits of a minute are half a second
    np.testing.assert_allclose(record.time_s, np.arange(ROWS) * STEP, atol=within_s)
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


@pytest.mark.parametrize(("form", "said"), [("%M:%S", "minutes and seconds"), ("%H:%M", "rows share a time")])
def test_times_of_two_numbers(tmp_path: Path, rig: Rig, form: str, said: str) -> None:
    assert_as_plain(write(tmp_path / "a.csv", rows(clock(form, "2026-03-01 23:58:00"))), rig, said)


def test_times_of_two_numbers_that_may_be_either_are_refused(tmp_path: Path, rig: Rig) -> None:
    path = write(tmp_path / "a.csv", rows(clock("%M:%S", "2026-03-01 23:58:00")))
    said = complaint(path, replace(rig, tick_s=1.0))
    assert said.startswith('line 2: \'58:00\' is of hours or of minutes? Say time_format = "%H:%M" or "%M:%S"')
    assert_as_plain(path, replace(rig, log=replace(rig.log, csv=Csv(time_format="%M:%S"))))


@pytest.mark.parametrize("commas", [range(1), range(1, 5)])
def test_times_with_another_decimal_mark_than_the_values(tmp_path: Path, rig: Rig, commas: range) -> None:
    cells = [
        [cell.replace(".", ",") if k in commas else cell for k, cell in enumerate(row)] for row in rows("{:.1f}".format)
    ]
    assert_as_plain(write(tmp_path / "a.csv", cells, sep=";"), rig)


def test_a_clock_of_twelve_hours_that_does_not_say_which(tmp_path: Path, rig: Rig) -> None:
    for form in ("%I:%M:%S", "%d.%m.%Y %I:%M:%S"):
        cells = rows(clock(form, "2026-03-13 12:58:00"))
        assert_as_plain(write(tmp_path / "a.csv", cells), rig, "times begin again after 43200 s")


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


@pytest.mark.parametrize("mark", [".", ","])
def test_minutes_and_seconds_as_excel_saves_them(tmp_path: Path, rig: Rig, mark: str) -> None:
    cells = rows(clock("%M:%S" + mark + "0", "2026-03-13 12:58:00"))
    assert_as_plain(write(tmp_path / "a.csv", cells, sep=";"), rig, "the clock was put back an hour at line 26")
