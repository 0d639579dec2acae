"""Ticks: the live road and the whole file give the same, however the log is broken; and what the breaks become."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from drivers import ticker as live
from drivers.budget import Budget
from drivers.decode import clock, condense
from drivers.frames import Tally
from drivers.logs.logs import read_log
from drivers.recordings import read_recording
from drivers.ticker import Ticker
from estimator.record import Recording, collect
from estimator.rig import Rig
from estimator.rig_log import Log
from tests import log_fake
from tests.conftest import RIG
from tests.log_fake import Row

STATUS = 0x214


def streamed(path: Path, rig: Rig = RIG) -> tuple[Recording, Ticker]:
    """The log frame by frame through the live road."""
    frames = read_log(path, Tally(), Budget())
    ticker = Ticker(rig)
    samples = []
    for k in range(len(frames)):
        data = frames.data[k, : frames.dlc[k]].tobytes()
        samples += ticker.feed(float(frames.time[k]), int(frames.id[k]), bool(frames.extended[k]), data)
    samples += ticker.flush()
    return collect(path.name, samples), ticker


def assert_same(one: Recording, other: Recording) -> None:
    for name in ("time_s", "channels", "ages_s", "omega", "coverage", "stay"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    for name, column in one.inputs.items():
        np.testing.assert_array_equal(column, other.inputs[name], err_msg=name)


def recorded(tmp_path: Path, rows: list[Row]) -> Recording:
    return read_recording(log_fake.write(tmp_path / "a.log", rows), RIG)


# Breaks: each turns rows into rows; `k` is a scan, `s` seconds, `n` a count.
def lose_status(rows: list[Row], k: int, s: float, n: int) -> list[Row]:
    status = [index for index, row in enumerate(rows) if row.id == STATUS][k % 20 : k % 20 + n]
    return [row for index, row in enumerate(rows) if index not in status]


def silence(rows: list[Row], k: int, s: float, n: int) -> list[Row]:
    begin = rows[0].time + k
    return [row for row in rows if not begin < row.time < begin + s]


def jump(rows: list[Row], k: int, s: float, n: int) -> list[Row]:
    begin = rows[0].time + k
    by = s * (-1) ** n
    return [row._replace(time=row.time + by) if row.time > begin else row for row in rows]


def stray(rows: list[Row], k: int, s: float, n: int) -> list[Row]:
    index = 37 * k % len(rows)
    return [*rows[:index], rows[index]._replace(time=rows[index].time + 100 * s), *rows[index + 1 :]]


def stand_still(rows: list[Row], k: int, s: float, n: int) -> list[Row]:
    begin = rows[0].time + k
    return [row._replace(time=begin) if begin < row.time < begin + n else row for row in rows]


def jitter(rows: list[Row], k: int, s: float, n: int) -> list[Row]:
    return [row._replace(time=row.time + s / 100 * ((index * 7919) % 13)) for index, row in enumerate(rows)]


def swap(rows: list[Row], k: int, s: float, n: int) -> list[Row]:
    index = 41 * k % (len(rows) - 1)
    return [*rows[:index], rows[index + 1], rows[index], *rows[index + 2 :]]


def foreign(rows: list[Row], k: int, s: float, n: int) -> list[Row]:
    at = 31 * k % len(rows)
    return [*rows[:at], *(Row(rows[at].time, 0x700 + j, bool(j % 2), bytes(n)) for j in range(n)), *rows[at:]]


def corrupt(rows: list[Row], k: int, s: float, n: int) -> list[Row]:
    at = 29 * k % len(rows)
    return [*rows[:at], rows[at]._replace(data=bytes([n]) * (8 - n % 3)), *rows[at + 1 :]]


def twice(rows: list[Row], k: int, s: float, n: int) -> list[Row]:
    return [row for row in rows for _ in range(2 if row.id == STATUS and int(row.time) % n == 0 else 1)]


BREAKS = (lose_status, silence, jump, stray, stand_still, jitter, swap, foreign, corrupt, twice)
BREAK = st.tuples(st.sampled_from(BREAKS), st.integers(0, 19), st.floats(0.01, 8.0), st.integers(1, 5))


@settings(max_examples=22, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    breaks=st.lists(BREAK, max_size=4), hertz=st.sampled_from([5, 20]), seed=st.integers(0, 3),
    at_once=st.sampled_from([4, 2048]),
)  # fmt: skip
def test_live_and_review_agree(tmp_path: Path, breaks: list, hertz: int, seed: int, at_once: int) -> None:
    """However many ticks of a log are worked out at once."""
    rows = log_fake.log(18, hertz, (3, 12), seed)
    for change, k, s, n in breaks:
        rows = change(rows, k, s, n)
    path = log_fake.write(tmp_path / "a.log", rows)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(condense, "AT_ONCE", at_once)
        whole = read_recording(path, RIG)
    live, ticker = streamed(path)
    assert_same(whole, live)
    assert whole.skipped == ticker.tally.counts()
    assert len(whole.notes) == len(ticker.tally.notes)
    assert (np.diff(whole.time_s) > 0).all()


BASE = log_fake.log(18, 20, (3, 12))
SCANS = 20 + 0.1 * np.arange(18)


@pytest.mark.parametrize(
    ("change", "k", "s", "n", "lost", "note"),
    [
        (lose_status, 5, 0, 2, [], None),
        (silence, 5, 4.3, 0, [5, 6, 7, 8], "silent for 4.3 s at 5.000 s (line 87)"),
        (jump, 5, 30, 0, [], "clock jumps ahead 30.050 s at 5.000 s (line 87): ticks go on"),
        (jump, 5, 30, 1, [], "clock jumps back 29.950 s at 5.000 s (line 87): ticks go on"),
        (jump, 5, 9000, 0, [], "clock jumps ahead 9000.050 s at 5.000 s (line 87): ticks go on"),
        (stray, 5, 3, 0, [], "stray time stamp at 8.600 s (line 186): left out"),
        (twice, 5, 0, 2, [], None),
        (jitter, 1, 1, 1, [], None),
        (foreign, 5, 0, 4, [], None),
    ],
)
def test_a_break_costs_only_its_ticks(tmp_path: Path, change, k, s, n, lost, note) -> None:
    record = recorded(tmp_path, change(BASE, k, s, n))
    expected = SCANS.copy()
    expected[lost] = np.nan
    np.testing.assert_allclose(record.channels[:, 0], expected)
    np.testing.assert_allclose(np.diff(record.time_s), 1, atol=0.03)
    assert record.notes == (() if note is None else (note,))


def stretched(rows: list[Row], tick_s: float) -> list[Row]:
    """The same log at another pace: whatever lasted a second lasts a tick."""
    return [row._replace(time=log_fake.START + tick_s * (row.time - log_fake.START)) for row in rows]


@pytest.mark.parametrize(
    ("change", "k", "s"), [(BREAKS[0], 0, 0.0), *((b, 5, 4.2) for b in BREAKS), (silence, 5, 2.2), (jump, 1.999, 30.0)]
)
@pytest.mark.parametrize(
    ("log", "tick_s"),
    [(RIG.log, 5.0), (replace(RIG.log, scan_number=None), 0.5), (Log(dbc="rig.dbc"), 0.5), (Log(dbc="rig.dbc"), 5.0)],
    ids=["scans", "unnumbered", "no scans, 0.5 s", "no scans, 5 s"],
)
def test_another_tick_is_another_pace_and_nothing_else(
    tmp_path: Path, change, k: float, s: float, log: Log, tick_s: float
) -> None:
    """Ages and times are in seconds, everything else is counted in ticks."""
    rows, usual = change(BASE, k, s, 2), replace(RIG, log=log)
    usual, rig = read_recording(log_fake.write(tmp_path / "a.log", rows), usual), replace(usual, tick_s=tick_s)
    path = log_fake.write(tmp_path / "b.log", stretched(rows, tick_s))
    record = read_recording(path, rig)
    assert (record.skipped, len(record.notes)) == (usual.skipped, len(usual.notes))
    for name in ("time_s", "ages_s"):
        np.testing.assert_allclose(getattr(record, name), tick_s * getattr(usual, name), atol=1e-5, err_msg=name)
    for name in ("channels", "omega", "coverage", "unevenness"):
        np.testing.assert_allclose(getattr(record, name), getattr(usual, name), rtol=1e-4, atol=1e-5, err_msg=name)
    assert_same(record, streamed(path, rig)[0])


@pytest.mark.parametrize(("tick_s", "age_s"), [(0.5, 0.1975), (1.0, 0.395), (5.0, 1.975)])
def test_a_late_reading_is_as_old_as_it_is(tmp_path: Path, tick_s: float, age_s: float) -> None:
    """The hold came 0.395 of a tick before its tick closed, the channels 1.2 ms of a second's tick before."""
    path = log_fake.write(tmp_path / "a.log", stretched(BASE, tick_s))
    record = read_recording(path, replace(RIG, tick_s=tick_s))
    np.testing.assert_allclose(record.ages_s[[3, 4, 6], RIG.index("displacement")], age_s, atol=1e-6)
    np.testing.assert_allclose(record.ages_s[:, 0], 0.0012 * tick_s, atol=2e-6)


LONG = log_fake.log(40, 5, (3, 30))
NARROW = replace(RIG, log=replace(RIG.log, scan_number="TelemeterStatus.TelCounter"))  # 4 bits, 0 ... 14


def test_a_live_bus_that_falls_silent(tmp_path: Path) -> None:
    ticker = Ticker(RIG)
    samples = [s for row in BASE[:87] for s in ticker.feed(row.time, row.id, row.extended, row.data)]
    assert len(samples) == 5
    assert not list(ticker.advance(log_fake.START + 6.4))
    (silent,) = ticker.advance(log_fake.START + 6.6)
    assert silent.time_s == pytest.approx(5.995)
    assert np.isnan(silent.channels).all()
    assert len(list(ticker.advance(log_fake.START + 16.6))) == 10
    later = log_fake.telemeter(log_fake.START + 16.995, 16)
    (sample,) = [s for row in later for s in ticker.feed(row.time, row.id, row.extended, row.data)]
    assert sample.channels[0] == 20


def test_frames_whose_stamps_stand_still_do_not_pile_up(monkeypatch) -> None:
    """Without a scan that would close a tick; before a jump of the clock, and after it."""
    monkeypatch.setattr(live, "MOST_OPEN", 300)
    monkeypatch.setattr(clock, "_MOST_WAITING", 200)
    ticker = Ticker(RIG)
    for row in BASE[:87]:
        list(ticker.feed(row.time, row.id, row.extended, row.data))
    drive = next(row for row in BASE if row.id != STATUS)
    for at, count in ((BASE[86].time, 1000), (BASE[86].time + 500.0, 1000)):
        for _ in range(count):
            list(ticker.feed(at, drive.id, drive.extended, drive.data))
            assert len(ticker._open) <= 300
            assert len(ticker.clock._waiting) <= 201
    assert ticker.tally.skipped["too many frames in one tick"] > 700


def test_the_timer_closes_ticks_of_a_rig_without_a_closing_message(tmp_path: Path) -> None:
    rig = replace(RIG, log=Log(dbc="rig.dbc"))
    path = log_fake.write(tmp_path / "a.log", BASE)
    record = read_recording(path, rig)
    np.testing.assert_allclose(record.time_s[:3], [0.5, 1.5, 2.5])
    np.testing.assert_allclose(record.channels[1:, 0], SCANS[: len(record) - 1])
    assert_same(record, streamed(path, rig)[0])


def test_ages_and_held_readings(tmp_path: Path) -> None:
    record = recorded(tmp_path, BASE)
    length = RIG.index("displacement")
    # a new hold in every second scan; each comes 0.395 s before its tick closes
    np.testing.assert_array_equal(np.flatnonzero(np.isfinite(record.channels[:, length])), [3, 4, 6, 8, 10])
    np.testing.assert_allclose(record.ages_s[[3, 4, 6], length], 0.395, atol=1e-6)
    np.testing.assert_allclose(record.channels[4, length], (4 * 0.2 + 4) / 2)
    assert record.skipped == {"held since before the log displacement_direct": 1}


def test_a_hold_that_is_repeated_from_the_start_is_not_a_reading(tmp_path: Path) -> None:
    old = [
        log_fake.frame(
            log_fake.START + k + 0.5, "DisplacementHold", DspHoldSeq=9, DspHoldState=0, DspHoldA1B1=30, DspHoldA2B2=30
        )
        for k in range(3)
    ]
    record = recorded(tmp_path, sorted([*BASE, *old], key=lambda row: row.time))
    assert np.isnan(record.channels[:3, RIG.index("displacement")]).all()
    assert record.skipped["held since before the log displacement"] == 1


def test_too_many_ticks_end_the_recording(tmp_path: Path) -> None:
    record = read_recording(log_fake.write(tmp_path / "a.log", BASE), RIG, budget=Budget(ticks=7))
    assert len(record) == 7
    assert record.notes == ("longer than 7 ticks: the recording ends at 7.0 s",)
