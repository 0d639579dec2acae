"""Logs of several buses: which is the rig's, and whose clock counts."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import can
import numpy as np
import pytest
from hypothesis import given, strategies as st

from drivers.decode.buses import on_one_clock
from drivers.frames import FRAME, Frames, Tally
from drivers.recordings import read_recording
from estimator.errors import InputError
from estimator.record import Recording
from tests import log_fake
from tests.conftest import RIG
from tests.log_fake import Row

ROWS = log_fake.log(40)
DRIVE = (0x220, 0x221, 0x230)


def write(path: Path, bus: Callable[[Row], str], clock: Callable[[Row], float]) -> Path:
    lines = [f"({clock(row):.6f}) {bus(row)} {row.id:03X}#{row.data.hex().upper()}\n" for row in ROWS]
    path.write_text("".join(lines))
    return path


def assert_same(one: Recording, two: Recording) -> None:
    np.testing.assert_array_equal(one.channels, two.channels)
    np.testing.assert_allclose(one.time_s, two.time_s, atol=0.02)
    np.testing.assert_allclose(one.omega, two.omega, rtol=0.05, atol=0.5)


def the_drive_on_can1(row: Row) -> str:
    return "can1" if row.id in DRIVE else "can0"


@pytest.mark.parametrize("lead_s", [0.8, -0.8, 3600.0, -1_600_000_000.0])
def test_two_clocks_are_made_one(tmp_path: Path, lead_s: float) -> None:
    def clock(row: Row) -> float:
        return row.time + lead_s * (row.id in DRIVE)

    record = read_recording(write(tmp_path / "a.log", the_drive_on_can1, clock), RIG)
    assert_same(record, read_recording(log_fake.write(tmp_path / "b.log", ROWS), RIG))
    assert any("the clocks of" in note for note in record.notes)


@pytest.mark.parametrize("batch_s", [0.06, 0.3, 2.0])
def test_batches_of_two_buses_on_one_clock(tmp_path: Path, batch_s: float) -> None:
    rows = sorted(ROWS, key=lambda row: (row.time // batch_s, row.id in DRIVE))
    lines = [f"({row.time:.6f}) {the_drive_on_can1(row)} {row.id:03X}#{row.data.hex()}\n" for row in rows]
    (tmp_path / "a.log").write_text("".join(lines))
    record = read_recording(tmp_path / "a.log", RIG)
    assert_same(record, read_recording(log_fake.write(tmp_path / "b.log", ROWS), RIG))
    assert record.notes == ("the rig's messages come on can0 and can1",)


def test_one_clock_is_left_alone_even_where_it_jumps(tmp_path: Path) -> None:
    def clock(row: Row) -> float:
        return row.time + 1000.0 * (row.time > log_fake.START + 20)

    record = read_recording(write(tmp_path / "a.log", the_drive_on_can1, clock), RIG)
    assert_same(record, read_recording(log_fake.write(tmp_path / "b.log", ROWS), RIG))
    assert not any("the clocks of" in note for note in record.notes)


def frames_of(time: np.ndarray, bus: np.ndarray) -> Frames:
    table = np.zeros(len(time), FRAME)
    table["time"], table["bus"] = time, bus
    return Frames.of([table], "line", ("can0", "can1"))


@given(lead=st.floats(-5, 5), drift=st.floats(-1e-3, 1e-3), seed=st.integers(0, 99))
def test_clocks_that_drift_apart_are_followed(lead: float, drift: float, seed: int) -> None:
    draw = np.random.default_rng(seed)
    true = np.cumsum(draw.uniform(0.001, 0.02, 4000))
    bus = draw.integers(0, 2, 4000)
    bus[0] = 0
    aligned = on_one_clock(frames_of(true + bus * (lead + drift * true), bus), "a.log", Tally())
    assert np.abs(aligned - true).max() < 0.07  # clocks this little apart are left alone


def test_clocks_that_hop_against_each_other_are_refused() -> None:
    draw = np.random.default_rng(1)
    true, bus = np.arange(4000) * 0.01, np.arange(4000) % 2
    with pytest.raises(InputError, match="the clocks of can1 and can0 are apart by no steady time"):
        on_one_clock(frames_of(true + bus * draw.uniform(0.5, 5, 4000), bus), "a.log", Tally())


def test_two_machines_in_a_log(tmp_path: Path) -> None:
    path, own, other = tmp_path / "a.log", log_fake.text(ROWS), log_fake.text(log_fake.log(40, seed=1))
    both = sorted([*own.splitlines(), *other.replace("can0", "can1").splitlines()])
    path.write_text("\n".join([*both, ""]))
    with pytest.raises(InputError) as error:
        read_recording(path, RIG)
    assert "come on the buses can0 and can1, two machines: name the rig's, such as bus" in str(error.value)
    alone = read_recording(log_fake.write(tmp_path / "b.log", ROWS), RIG)
    for bus in ("can0", 0):
        assert_same(read_recording(path, replace(RIG, log=replace(RIG.log, bus=bus))), alone)
    with pytest.raises(InputError, match=r"no frame of bus 'can7', rig\.toml's log\.bus; it has can0, can1"):
        read_recording(path, replace(RIG, log=replace(RIG.log, bus="can7")))


def test_the_number_of_a_bus_is_the_one_in_the_log(tmp_path: Path) -> None:
    alone = read_recording(log_fake.write(tmp_path / "b.log", ROWS), RIG)
    with can.Logger(tmp_path / "a.asc") as writer:
        for row in sorted([*ROWS, *(r._replace(id=r.id, time=r.time + 0.0001) for r in log_fake.log(40, seed=1))]):
            channel = int(row not in ROWS)
            writer.on_message_received(
                can.Message(row.time, row.id, is_extended_id=False, data=row.data, channel=channel)
            )
    with pytest.raises(InputError, match=r'buses can0 = channel 1 and can1 = channel 2, two machines: .*bus = "can0"'):
        read_recording(tmp_path / "a.asc", RIG)
    for bus in ("can0", 1):
        assert_same(read_recording(tmp_path / "a.asc", replace(RIG, log=replace(RIG.log, bus=bus))), alone)


def test_a_bus_that_has_nothing_of_the_rig_does_not_touch_its_clock(tmp_path: Path) -> None:
    lines = log_fake.text(ROWS).splitlines()
    strangers = [f"({k * 0.5:.6f}) can9 7A0#00" for k in range(len(lines))]
    path = tmp_path / "a.log"
    path.write_text("\n".join([line for pair in zip(lines, strangers) for line in pair] + [""]))
    record = read_recording(path, RIG)
    assert_same(record, read_recording(log_fake.write(tmp_path / "b.log", ROWS), RIG))
    assert record.skipped["on can9, where nothing of the rig is"] == len(lines)


def test_parts_the_wrong_way_round_and_a_log_from_its_end(tmp_path: Path) -> None:
    lines = log_fake.text(ROWS).splitlines(keepends=True)
    plain = read_recording(log_fake.write(tmp_path / "b.log", ROWS), RIG)
    half = len(lines) // 2
    for order, said in (
        ([*lines[half:], *lines[:half]], "its 2 parts are the wrong way round: put in the order of their times"),
        (lines[::-1], "newest frame first: turned round"),
    ):
        (tmp_path / "a.log").write_text("".join(order))
        record = read_recording(tmp_path / "a.log", RIG)
        assert_same(record, plain)
        assert said in record.notes


def test_times_that_count_from_the_frame_before_are_refused(tmp_path: Path) -> None:
    stamps = np.diff([row.time for row in ROWS], prepend=ROWS[0].time)
    path = log_fake.write(tmp_path / "a.log", [row._replace(time=time) for row, time in zip(ROWS, stamps)])
    with pytest.raises(InputError, match="as if each counted from the one before: no clock does"):
        read_recording(path, RIG)


def test_buses_that_begin_and_end_apart_by_the_same_are_doubted(tmp_path: Path) -> None:
    rows = sorted((row._replace(time=row.time + 8 * (row.id in DRIVE)) for row in ROWS), key=lambda row: row.time)
    lines = [f"({row.time:.6f}) {the_drive_on_can1(row)} {row.id:03X}#{row.data.hex()}\n" for row in rows]
    (tmp_path / "a.log").write_text("".join(lines))
    notes = read_recording(tmp_path / "a.log", RIG).notes
    assert any("can1 begins and ends +7.0 s from can0: are their clocks apart" in note for note in notes)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("again_s", [2.0, 100.0])
def test_parts_of_a_log_that_overlap_are_read_once(tmp_path: Path, turned: bool, again_s: float) -> None:
    rows = log_fake.log(20)
    middle = rows[0].time + 10.0
    parts = [[r for r in rows if r.time < middle], [r for r in rows if r.time >= middle - again_s]]
    path = log_fake.write(tmp_path / "a.log", [row for part in parts[:: -1 if turned else 1] for row in part])
    record, same = read_recording(path, RIG), read_recording(log_fake.write(tmp_path / "b.log", rows), RIG)
    np.testing.assert_array_equal(record.channels, same.channels)
    np.testing.assert_allclose(record.time_s, same.time_s)
    assert any(note.endswith("frames are there twice: read once") for note in record.notes)


def test_frames_that_a_gateway_sends_twice_close_their_tick_once(tmp_path: Path) -> None:
    rows = log_fake.log(40)
    again = [each for row in rows for each in (row, row._replace(time=row.time + 7e-4))]
    record = read_recording(log_fake.write(tmp_path / "a.log", again), RIG)
    same = read_recording(log_fake.write(tmp_path / "b.log", rows), RIG)
    np.testing.assert_allclose(record.time_s, same.time_s, atol=1e-3)
    np.testing.assert_array_equal(record.channels, same.channels)
    assert record.skipped["closing message too soon (used)"] == len(same)


@pytest.mark.parametrize("times", [1e-3, 1e3])
def test_stamps_that_count_something_else_than_seconds_are_refused(tmp_path: Path, times: float) -> None:
    rows = log_fake.log(40)
    slow = [row._replace(time=rows[0].time + times * (row.time - rows[0].time)) for row in rows]
    with pytest.raises(InputError, match=r"closes a tick comes each \S+ s, .* count something else than second"):
        read_recording(log_fake.write(tmp_path / "a.log", slow), RIG)
