"""Rows whose times go back, stand still, begin again or come twice."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest

from drivers.recordings import read_recording
from estimator.rig import Rig
from tests.drivers.lab.conftest import assert_as_plain, clock, complaint, rows, write


def test_rows_out_of_order(tmp_path: Path, rig: Rig) -> None:
    plain = rows()
    assert_as_plain(write(tmp_path / "a.csv", plain[::-1]), rig, "newest row first, turned round")
    assert_as_plain(
        write(tmp_path / "a.csv", [*plain[40:], *plain[:40]]), rig, "rows sorted by time: it went back 1 times"
    )
    late = [*plain[:20], *plain[21:24], plain[20], *plain[24:]]
    assert_as_plain(write(tmp_path / "a.csv", late), rig, "rows sorted by time")


@pytest.mark.parametrize("sort", [None, True])
@pytest.mark.parametrize("stamp", ["{:g}".format, clock("%Y-%m-%dT%H:%M:%S")])
def test_rows_in_the_order_of_something_else(tmp_path: Path, rig: Rig, stamp: Callable, sort: bool | None) -> None:
    """As a spreadsheet sorts them by a reading: half of all steps go back, and none from row to row is the rig's."""
    sorts = replace(rig, log=replace(rig.log, csv=replace(rig.log.csv, sort=sort)))
    mixed = Random(1).sample(rows(stamp), len(rows()))
    assert_as_plain(write(tmp_path / "a.csv", mixed), sorts, "rows sorted by time: it went back")


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


@pytest.mark.parametrize("per_s", [1, 1000, 1 / 60])
@pytest.mark.parametrize("period", [86400, 604800, 43200, 2**16, 2**32 / 1e6, 2**32 / 1e3])
def test_times_that_begin_again_go_on(tmp_path: Path, rig: Rig, per_s: float, period: float) -> None:
    cells = rows(lambda s: f"{(period - 100 + s) % period * per_s:.6f}")
    said = f"times begin again after {period:.10g} s"
    assert_as_plain(write(tmp_path / "a.csv", cells), rig, said)
    assert_as_plain(write(tmp_path / "a.csv", cells[::-1]), rig, said, "newest row first")


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
