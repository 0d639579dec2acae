"""How old frames are: what waited in buffers is told from what a clock did."""

import pytest

from drivers.bus.age import Age

STAMP = 1.7e9


def ages(rows: list[tuple[float, float, bool]]) -> list[float]:
    """Of frames (stamp after the first, received at, waited for)."""
    age = Age()
    return [age.of(STAMP + stamp, now, waited) for stamp, now, waited in rows]


def steady(seconds: int, stamp: float = 0.0, now: float = 50.0) -> list[tuple[float, float, bool]]:
    return [(stamp + k, now + k, False) for k in range(seconds)]


def test_frames_that_come_at_once_are_new():
    assert max(ages(steady(3600))) < 1e-6


def test_a_reader_that_was_held_up_reads_what_is_old_and_catches_up():
    backlog = [(10.0 + k, 80.0 + k / 10, False) for k in range(30)]
    found = ages([*steady(10), *backlog])
    assert found[10] == pytest.approx(20.0, abs=0.05)
    assert found[11:] == sorted(found[11:], reverse=True)
    assert found[-1] < 0.1


def test_a_flood_that_is_read_at_half_its_pace_gets_older_and_older():
    flood = [(10.0 + k / 2, 60.0 + k, False) for k in range(41)]
    assert ages([*steady(10), *flood])[-1] == pytest.approx(20.0, abs=0.1)


def test_who_waited_for_a_frame_has_nothing_in_the_buffers():
    """The clock was set back by 7 s in a silence of 10 s."""
    assert ages([*steady(10), (12.0, 69.0, True), *steady(5, 13.0, 70.0)])[10:] == [0.0] * 6


@pytest.mark.parametrize("jump_s", [-3600.0, -2.0, 3.0, 3600.0, 4e9])
def test_a_clock_that_is_set_makes_nothing_old(jump_s):
    assert max(ages([*steady(10), *steady(100, 10.0 + jump_s, 60.0)])) < 1e-6


def test_a_stray_stamp_makes_nothing_old():
    assert max(ages([*steady(10), (1e6, 60.0, False), *steady(100, 11.0, 61.0)])) < 1e-6


def test_clocks_that_stand_still_or_are_coarse_make_nothing_old():
    assert max(ages([(0.0, 50.0 + k / 10, False) for k in range(1000)])) == 0.0
    assert max(ages([(float(k // 10), 50.0 + k / 10, False) for k in range(1000)])) < 1e-6


def test_a_clock_that_runs_slower_makes_nothing_old():
    assert max(ages([(0.9995 * k, 50.0 + k, False) for k in range(20_000)])) < 0.01
