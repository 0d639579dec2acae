"""Ticks: the live road and the whole file give the same, however the log is broken; and what the breaks become."""

from __future__ import annotations

from pathlib import Path

import log_fake
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from log_fake import Row

from drivers.budget import Budget
from drivers.clock import RigClock
from drivers.frames import Tally
from drivers.logs import read_log
from drivers.recordings import read_recording
from drivers.ticker import Ticker
from estimator.record import Recording, collect
from estimator.rig import Rig, load_rig

RIG = load_rig(Path(__file__).parents[1] / "recordings")
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
    for name in ("time_s", "channels", "ages_s", "omega", "coverage"):
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


@settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(breaks=st.lists(BREAK, max_size=4), hertz=st.sampled_from([5, 20]), seed=st.integers(0, 3))
def test_live_and_review_agree(tmp_path: Path, breaks: list, hertz: int, seed: int) -> None:
    rows = log_fake.log(18, hertz, (3, 12), seed)
    for change, k, s, n in breaks:
        rows = change(rows, k, s, n)
    path = log_fake.write(tmp_path / "a.log", rows)
    whole = read_recording(path, RIG)
    live, ticker = streamed(path)
    assert_same(whole, live)
    assert whole.skipped == ticker.tally.counts()
    assert len(whole.notes) == len(ticker.tally.notes)
    assert (np.diff(whole.time_s) > 0).all()


if __name__ == "__main__":
    raise SystemExit(pytest.main([__file__]))
