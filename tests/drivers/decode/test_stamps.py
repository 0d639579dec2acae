"""Clocks that were not set, stand still or jump, and scan numbers that start again."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.budget import Budget
from drivers.decode.clock import RigClock
from drivers.frames import Tally
from drivers.recordings import read_recording
from tests import log_fake
from tests.drivers.decode.test_ticks import (
    BASE,
    LONG,
    NARROW,
    RIG,
    SCANS,
    assert_same,
    jump,
    recorded,
    silence,
    stand_still,
    streamed,
    stretched,
)
from tests.log_fake import START


def test_stamps_that_stand_still_count_by_scans(tmp_path: Path) -> None:
    record = recorded(tmp_path, stand_still(BASE, 5, 0, 3))
    assert record.notes == ("time stands still at 5.000 s (line 143): each scan counts as one tick",)
    assert record.skipped["closing message too soon (used)"] == 1
    assert len(record) == 17  # the scan that came with the stamp of the one before shares its tick


@pytest.mark.parametrize("k", [5, 14, 15, 16, 30])
@pytest.mark.parametrize("n", [0, 1])
def test_a_scan_number_starts_again_where_the_dbc_says(tmp_path: Path, k: int, n: int) -> None:
    """Before scan 15 and 30 it goes from 14 to 0: a jump of the clock there is one all the same."""
    path = log_fake.write(tmp_path / "a.log", jump(LONG, k, 38.0, n))
    record = read_recording(path, NARROW)
    np.testing.assert_allclose(record.channels[:, 0], 20 + 0.1 * np.arange(40))
    np.testing.assert_allclose(np.diff(record.time_s), 1, atol=0.03)
    assert record.notes[0].startswith(f"clock jumps {('ahead', 'back')[n]} 3")
    assert_same(record, streamed(path, NARROW)[0])


@pytest.mark.parametrize("s", [4.3, 16.3, 20.3, 33.3])
def test_a_silence_longer_than_the_scan_number_counts_is_no_jump(tmp_path: Path, s: float) -> None:
    path = log_fake.write(tmp_path / "a.log", silence(LONG, 5, s, 0))
    record = read_recording(path, NARROW)
    assert len(record) == 40
    (note,) = record.notes
    assert note.startswith("silent for")
    assert np.isnan(record.channels[5 : 5 + int(s), 0]).all()
    assert record.channels[-1, 0] == pytest.approx(23.9)


def test_without_scan_numbers_a_jump_ahead_is_silence(tmp_path: Path) -> None:
    rig = replace(RIG, log=replace(RIG.log, scan_number=None))
    record = read_recording(log_fake.write(tmp_path / "a.log", jump(BASE, 5, 30, 0)), rig)
    assert record.notes == ("silent for 30.0 s at 5.000 s (line 87)",)
    assert len(record) == 48


def test_silence_over_an_hour_ends_the_recording(tmp_path: Path) -> None:
    rig = replace(RIG, log=replace(RIG.log, scan_number=None))
    record = read_recording(log_fake.write(tmp_path / "a.log", jump(BASE, 5, 9000, 0)), rig)
    assert record.notes == ("silent for 2.5 h at 5.000 s (line 87): the recording ends there",)
    assert len(record) == 5
    assert record.skipped["after the end of the recording"] == len(BASE) - 86


@pytest.mark.parametrize("tick_s", [0.5, 1.0, 5.0])
def test_a_clock_that_is_set_in_the_second_tick_was_not_set_before(tmp_path: Path, tick_s: float) -> None:
    """It costs that tick. Without scan numbers, as long a jump after the third is a night's silence."""
    rig = replace(RIG, tick_s=tick_s, log=replace(RIG.log, scan_number=None))
    for k, ticks in ((1, 17), (3, 3)):
        rows = stretched(jump(BASE, k, 9000, 0), tick_s)
        assert len(read_recording(log_fake.write(tmp_path / "a.log", rows), rig)) == ticks


def test_a_first_stamp_that_was_not_set(tmp_path: Path) -> None:
    record = recorded(tmp_path, [BASE[0]._replace(time=0.0), *BASE[1:]])
    np.testing.assert_allclose(record.channels[:, 0], SCANS)


@pytest.mark.parametrize("ahead_s", [100.0, 3000.0, 1e6])
def test_a_log_whose_last_stamp_is_far_ahead_is_no_longer_for_it(tmp_path: Path, ahead_s: float) -> None:
    """Nothing confirms it; a short silence before the last frames is believed."""
    drive = BASE[-40]._replace(time=BASE[-1].time + ahead_s)
    record = recorded(tmp_path, [*BASE, drive])
    assert len(record) == len(recorded(tmp_path, BASE))
    assert record.skipped["stray time stamp"] == 1
    late = recorded(tmp_path, [*BASE, drive._replace(time=BASE[-1].time + 10.0)])
    assert len(late) == len(record) + 10


def clocked(modulus: int, jump_s: float, at: int, lost: int = 0) -> tuple[float, list[str]]:
    """Where the rig's clock ends after 120 scans of 11 frames, 1 s each, and its notes.

    The stamps jump with frame `at`, before which `lost` frames did not come.
    """
    number = np.delete(np.arange(120 * 11), np.s_[at - lost : at])
    stamps = START + 0.09 * (number % 11) + number // 11 + np.where(number >= at, jump_s, 0.0)
    closes = number % 11 == 10
    scan = np.where(closes, (number // 11 + 200) % modulus, -1)
    tally = Tally()
    now = RigClock(1.0, modulus, tally, str, Budget()).run(stamps, closes, scan)
    slow = RigClock(1.0, modulus, Tally(), str, Budget())
    steps = zip(stamps.tolist(), closes.tolist(), scan.tolist(), strict=True)
    placed = [pair for k, row in enumerate(steps) for pair in slow.step(k, *row)]
    np.testing.assert_allclose([t for _, t in placed], now[np.isfinite(now)], atol=1e-6)
    return float(np.nanmax(now)), tally.notes


@pytest.mark.parametrize("modulus", [15, 16, 256, 65536])
@pytest.mark.parametrize("at", [60 * 11, 60 * 11 + 4, 61 * 11 - 1], ids=["between scans", "in one", "at its end"])
def test_a_clock_that_jumps_by_what_a_narrow_number_counts_to(modulus: int, at: int) -> None:
    """The number alone would say that it has started again meanwhile: whole hours are so many 15 and 16 s."""
    for turns in (1, 5, 40_000):
        for off in (-1.0, 0.0, 1.0):
            end, (note,) = clocked(modulus, turns * modulus + off, at)
            assert end == pytest.approx(119.9, abs=1.0)
            assert note.startswith("clock jumps ahead")


@pytest.mark.parametrize("modulus", [15, 16, 256])
@pytest.mark.parametrize("lost", [3, 7, 16])
def test_a_silence_is_one_though_the_narrow_number_has_started_again_in_it(modulus: int, lost: int) -> None:
    """Frames of a scan are missing where it began, or where it ended, or there are too many for one."""
    end, (note,) = clocked(modulus, 2.0 * modulus, 61 * 11 - 2, lost)
    assert note.startswith(f"silent for {2 * modulus + lost // 11}.")
    assert end == pytest.approx(119.9 + 2 * modulus, abs=0.1)


def test_a_clock_that_finds_its_date_is_no_silence_of_decades() -> None:
    stamps = np.concatenate([np.arange(20.0), 1.7e9 + np.arange(20.0, 60.0)])
    tally, none = Tally(), np.full(60, -1, np.int64)
    clock = RigClock(1.0, 1, tally, lambda row: f"line {row}", Budget(), step_s=1.0)
    np.testing.assert_allclose(clock.run(stamps, np.zeros(60, bool), none), np.arange(60.0), atol=1e-6)
    assert tally.notes == ["clock jumps ahead 1700000001.000 s at 19.000 s (line 20): ticks go on"]
