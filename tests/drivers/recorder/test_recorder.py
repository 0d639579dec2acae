"""The recorder: its text, its files, and what is left of them when the disk, the process or a colleague gives out."""

from __future__ import annotations

import errno
import json
import math
import subprocess
import threading
from pathlib import Path
from unittest import mock

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.budget import Budget
from drivers.frames import Tally, words_of
from drivers.logs.candump import read_candump
from drivers.logs.candump_line import frame_of, line_of
from drivers.received import Received, received_of
from drivers.recorder.recorder import Recorder
from drivers.recordings import find_recordings, read_recording
from estimator.errors import SetupError
from tests import log_fake
from tests.drivers.decode.test_ticks import RIG, assert_same
from tests.processes import PATIENCE_S, ended, started, until

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


def test_what_is_written_is_brought_to_the_disk_and_nobody_waits_for_that(tmp_path: Path) -> None:
    slow, begun = threading.Event(), threading.Event()

    def disk(fd: int) -> None:
        begun.set()
        assert slow.wait(PATIENCE_S)

    with mock.patch("drivers.recorder.part._data_to_disk", disk), Recorder(tmp_path, {}, sync_s=0.01) as recorder:
        recorder.write(frame())
        assert begun.wait(PATIENCE_S)
        for k in range(1, 1000):
            recorder.write(frame(k))
        assert len(lines(recorder.path)) == 1000
        slow.set()


def test_a_disk_that_cannot_be_synced_is_said(tmp_path: Path) -> None:
    broken = OSError(5, "Input/output error")
    with Recorder(tmp_path, {}, sync_s=0.01) as recorder:
        recorder.write(frame())
        with mock.patch("drivers.recorder.part._data_to_disk", side_effect=broken):
            until(lambda: recorder.trouble)
            assert recorder.trouble == (
                f"input/output error: {recorder.path}: a power cut may take more than the last second"
            )
        until(lambda: not recorder.trouble)
        recorder.write(frame())
    assert recorder.frames == 2


FULL = """
import json, resource, sys, time
from pathlib import Path
from unittest import mock
from drivers.logs.candump_line import line_of
from drivers.received import Received
from drivers.recorder.recorder import Recorder

clock = mock.patch("drivers.recorder.recorder.time.monotonic", side_effect=lambda: now).start()
now = 0.0
line = len(line_of(Received(1.7e9, 0x210, False, b"ab")))
hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
told = []
with Recorder(Path(sys.argv[1]), {}, sync_s=60.0) as recorder:
    def write(count):
        for _ in range(count):
            recorder.write(Received(1.7e9 + recorder.frames + recorder.lost, 0x210, False, b"ab"))
        told.append([recorder.frames, recorder.lost, recorder.trouble, recorder.path.stat().st_size / line])
    write(2)
    while not recorder.path.with_suffix(".json").exists():
        time.sleep(0.001)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3 * line + line // 2, hard))
    write(5)
    now = 1.1
    write(1)
    resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
    now = 2.0
    write(1)
    now = 2.2
    write(3)
print(json.dumps([told, recorder.notes]))
"""


def test_a_full_disk_leaves_whole_lines_and_is_over_when_there_is_room(tmp_path: Path) -> None:
    """A real limit, which takes half of the fourth line."""
    pytest.importorskip("resource")
    done = ended("-c", FULL, tmp_path)
    assert done.returncode == 0, done.stderr
    (two, full, still, soon, again), notes = json.loads(done.stdout)
    full_since = f"{tmp_path}: frames not recorded since 22:13:23 UTC"
    assert two == [2, 0, "", 2]
    assert full == [3, 4, f"disk full: {full_since}", 3]
    assert still == [3, 5, f"disk full: {full_since}", 3]
    assert soon == [3, 6, f"disk full: {full_since}", 3]
    assert again == [6, 6, "", 6]
    assert notes == ["6 frames not recorded from 22:13:23 to 22:13:29 UTC: disk full"]
    frames, _ = read_candump(tmp_path / f"{STEM}.log", tally := Tally(), Budget())
    assert (frames.time - START).tolist() == [0, 1, 2, 9, 10, 11]
    assert not tally.skipped


def test_a_folder_that_goes_away_is_said_and_used_again_when_it_is_back(tmp_path: Path) -> None:
    folder = tmp_path / "disk"
    with mock.patch("drivers.recorder.recorder._RETRY_S", 0.0), Recorder(folder, {}, sync_s=0.01) as recorder:
        for round_ in (1, 2):
            recorder.write(frame())
            folder.rename(tmp_path / f"taken_out_{round_}")
            until(lambda: len(recorder.notes) == 2 * round_ - 1)  # noqa: B023
            recorder.write(frame(1))
            assert recorder.trouble.startswith(f"no such file or directory: {folder}: frames not recorded since ")
            folder.mkdir()
            recorder.write(frame(2))
            assert (recorder.lost, recorder.trouble) == (round_, "")
    assert recorder.notes[::2] == [f"{STEM}.log was deleted or renamed while it was written; a new file begins"] * 2
    assert all(note.startswith("1 frames not recorded from 22:13:20 to ") for note in recorder.notes[1::2])
    assert lines(recorder.path) == [line_of(frame(2))]
    assert recorder.path.parent == folder


def test_after_the_end_frames_are_lost_and_nothing_is_raised(tmp_path: Path) -> None:
    with Recorder(tmp_path, {}) as recorder:
        recorder.write(frame())
    recorder.write(frame(1))
    recorder.close()
    assert (recorder.frames, recorder.lost) == (1, 1)


WRITER = """
import sys
from pathlib import Path
from drivers.received import Received
from drivers.recorder.recorder import Recorder

recorder = Recorder(Path(sys.argv[1]), {})
k = 0
while True:
    for _ in range(500):
        recorder.write(Received(1.7e9 + k / 8000, 0x210, False, k.to_bytes(8, "big")))
        k += 1
    print(k, flush=True)
"""


def test_kill_9_takes_nothing_that_was_written_and_frees_the_folder(tmp_path: Path) -> None:
    with started("-c", WRITER, tmp_path, stdout=subprocess.PIPE) as process:
        assert process.stdout
        for _ in range(20):
            told = int(process.stdout.readline())
        with pytest.raises(SetupError) as error:
            Recorder(tmp_path, {})
        process.kill()
        rest = process.stdout.read().split("\n")
    assert str(error.value) == (
        f"{tmp_path}: process {process.pid} already records there; end it or name another folder"
    )
    told = max([told, *(int(word) for word in rest[:-1])])
    (path,) = find_recordings([tmp_path])
    frames, _ = read_candump(path, Tally(), Budget())
    assert len(frames) >= told
    assert words_of(frames.data)[1].tolist() == list(range(len(frames)))
    with Recorder(tmp_path, {}) as recorder:
        recorder.write(frame())
    assert recorder.path.name == f"{STEM}-2.log"


def test_a_folder_that_cannot_be_used_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(SetupError) as error:
        Recorder(tmp_path / "file", {})
    assert str(error.value) == f"{tmp_path / 'file'}: cannot record there: File exists; name another folder"


def test_two_recorders_of_one_process_do_not_share_a_folder_either(tmp_path: Path) -> None:
    with Recorder(tmp_path, {}), pytest.raises(SetupError, match="already records there"):
        Recorder(tmp_path, {})


def test_a_folder_whose_disk_knows_no_locks_is_recorded_into(tmp_path: Path) -> None:
    fcntl = pytest.importorskip("fcntl")
    with (
        mock.patch.object(fcntl, "flock", side_effect=OSError(errno.ENOLCK, "No locks available")),
        Recorder(tmp_path, {}) as recorder,
    ):
        recorder.write(frame())
    assert recorder.frames == 1
    with Recorder(tmp_path, {}) as again:
        again.write(frame(1))
    assert again.frames == 1
