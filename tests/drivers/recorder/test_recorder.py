"""The recorder: its text, its files, and what is left of them when the disk, the process or a colleague gives out."""

import json
import math
from pathlib import Path

import can
from hypothesis import given, strategies as st

from drivers.budget import Budget
from drivers.frames import Tally
from drivers.logs.candump import read_candump
from drivers.logs.candump_line import frame_of, line_of
from drivers.received import Received, received_of
from drivers.recorder.recorder import Recorder
from drivers.recordings import find_recordings, read_recording
from tests import log_fake
from tests.drivers.decode.test_ticks import RIG, assert_same
from tests.processes import until

START = 1_700_000_000.0  # 2023-11-14 22:13:20 UTC
STEM = "2023-11-14T22-13-20Z"
HOUR = 3600.0


def frame(k: int = 0, **changes: object) -> Received:
    return Received(START + k / 1000, 0x210, False, bytes([k & 255, 1]))._replace(**changes)


def lines(path: Path) -> list[str]:
    return path.read_text().splitlines(keepends=True)


def sidecar(path: Path) -> dict:
    return json.loads(path.with_suffix(".json").read_text())


TIMES = st.integers(0, 4_000_000_000_000_000).map(lambda us: us / 1e6)
IDS = st.one_of(st.tuples(st.integers(0, 0x7FF), st.just(False)), st.tuples(st.integers(0, 0x1FFFFFFF), st.just(True)))
DATA = st.binary(max_size=8)
LONG = st.binary(max_size=64)


@given(
    st.one_of(
        st.builds(lambda t, i, d: Received(t, *i, d, "data", "can0", len(d)), TIMES, IDS, DATA),
        st.builds(lambda t, i, n: Received(t, *i, b"", "remote", "vcan1", n), TIMES, IDS, st.integers(0, 8)),
        st.builds(lambda t, i, d: Received(t, i[0], True, d, "error", "can0", len(d)), TIMES, IDS, DATA),
        st.builds(lambda t, i, d, f: Received(t, *i, d, "fd", "can0", len(d), f), TIMES, IDS, LONG, st.integers(0, 3)),
    )
)
def test_a_line_and_its_frame_are_the_same(one: Received) -> None:
    assert frame_of(line_of(one)) == one


def test_what_a_line_looks_like(tmp_path: Path) -> None:
    bus = {"is_extended_id": False, "arbitration_id": 0x123}
    messages = [
        can.Message(**bus, data=[0x11, 0x22, 0xAA, 0xBB]),
        can.Message(arbitration_id=0x123, is_extended_id=True, data=[1]),
        can.Message(**bus),
        can.Message(**bus, is_remote_frame=True, dlc=4),
        can.Message(**bus, is_remote_frame=True),
        can.Message(arbitration_id=0x80, is_error_frame=True, data=bytes(8)),
        can.Message(**bus, is_fd=True, bitrate_switch=True, data=range(12)),
    ]
    with Recorder(tmp_path, {}) as recorder:
        for message in messages:
            recorder.write(received_of(message, 1_700_000_000.1234567, "can 0"))
    assert [line.removeprefix("(1700000000.123457) can_0 ") for line in lines(recorder.path)] == [
        "123#1122AABB\n",
        "00000123#01\n",
        "123#\n",
        "123#R4\n",
        "123#R\n",
        "20000080#0000000000000000\n",
        "123##1000102030405060708090A0B\n",
    ]
    frames, _ = read_candump(recorder.path, tally := Tally(), Budget())
    assert len(frames) == 3
    assert tally.counts() == {"remote frame": 2, "error frame": 1, "CAN FD frame": 1}


def test_a_folder_is_a_recording_like_any_other(tmp_path: Path) -> None:
    rows = log_fake.log(12, 10, (3, 9))
    with Recorder(tmp_path / "new" / "runs", {"rig": "paper"}) as recorder:
        for row in rows:
            recorder.write(Received(*row))
    assert find_recordings([tmp_path / "new" / "runs"]) == [recorder.path]
    assert_same(
        read_recording(recorder.path, RIG), read_recording(log_fake.write(tmp_path / "expected.log", rows), RIG)
    )
    assert recorder.frames == len(rows)
    assert (recorder.lost, recorder.trouble, recorder.notes) == (0, "", [])


def test_a_new_file_begins_with_its_hour_and_with_its_size(tmp_path: Path) -> None:
    line = len(line_of(frame()))
    with Recorder(tmp_path, {"rig": "paper"}, hours=1.0, size_bytes=3 * line) as recorder:
        assert recorder.path == tmp_path
        for k in (0, 1, 2, 3):
            recorder.write(frame(k))
        recorder.write(frame(0, time_s=START + HOUR + 0.003))
        recorder.write(frame(0, time_s=START + HOUR + 0.004))
    files = [tmp_path / name for name in (f"{STEM}.log", f"{STEM}-2.log", "2023-11-14T23-13-20Z.log")]
    assert sorted(tmp_path.glob("*.log")) == sorted(files)
    assert [len(lines(path)) for path in files] == [3, 1, 2]
    told = [sidecar(path) for path in files]
    assert [one["part"] for one in told] == [1, 2, 3]
    assert [one["before"] for one in told] == [None, files[0].name, files[1].name]
    assert [one["frames"] for one in told] == [3, 1, 2]
    assert all(one["closed"] and one["about"] == {"rig": "paper"} for one in told)
    assert (told[0]["first_s"], told[0]["last_s"]) == (START, START + 0.002)
    assert recorder.path == files[2]
    assert not list(tmp_path.glob("*.part"))


def test_what_comes_after_a_night_has_a_file_of_its_own(tmp_path: Path) -> None:
    with Recorder(tmp_path, {}, own={(0x610, False)}) as recorder:
        for time_s in (START, START + HOUR - 1, START + 9 * HOUR, START + 9 * HOUR + 1):
            recorder.write(frame(time_s=time_s))
            recorder.write(frame(time_s=time_s + 0.9 * HOUR, id=0x610))
    assert [len(lines(path)) for path in sorted(tmp_path.glob("*.log"))] == [4, 4]


def test_stamps_that_stray_into_the_future_do_not_fill_the_folder_with_files(tmp_path: Path) -> None:
    with Recorder(tmp_path, {}) as recorder:
        for k in range(1000):
            recorder.write(frame(k, time_s=START + k + (1e6 if k % 10 == 5 else 0.0)))
    assert recorder.frames == 1000
    assert len([*tmp_path.glob("*.log")]) < 10


def test_a_file_that_is_there_stays_as_it_is(tmp_path: Path) -> None:
    """The clock was set back over a recording, and of another one only the sidecar is left."""
    (tmp_path / f"{STEM}.log").write_text("kept\n")
    (tmp_path / f"{STEM}-2.json").write_text("{}")
    with Recorder(tmp_path, {}) as recorder:
        recorder.write(frame())
    assert recorder.path.name == f"{STEM}-3.log"
    assert (tmp_path / f"{STEM}.log").read_text() == "kept\n"
    assert (tmp_path / f"{STEM}-2.json").read_text() == "{}"


def test_stamps_that_are_no_time_are_recorded_too(tmp_path: Path) -> None:
    with Recorder(tmp_path, {}) as recorder:
        for stamp in (math.nan, 1e300, -5.0, START):
            recorder.write(frame(time_s=stamp))
    assert recorder.frames == 4
    assert recorder.lost == 0


def test_the_sidecar_is_there_while_the_file_is_written(tmp_path: Path) -> None:
    with Recorder(tmp_path, {"rig": "paper"}, sync_s=60.0) as recorder:
        recorder.write(frame())
        until(lambda: recorder.path.with_suffix(".json").exists())
        assert sidecar(recorder.path)["closed"] is False
        assert lines(recorder.path) == [line_of(frame())]
