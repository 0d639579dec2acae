"""A recorder and its disk: full, gone, without locks; and a process that is killed."""

import errno
import json
import subprocess
import threading
from pathlib import Path
from unittest import mock

import pytest

from drivers.budget import Budget
from drivers.frames import Tally, words_of
from drivers.logs.candump import read_candump
from drivers.logs.candump_line import line_of
from drivers.recorder.recorder import Recorder
from drivers.recordings import find_recordings
from estimator.errors import SetupError
from tests.drivers.recorder.test_recorder import START, STEM, frame, lines
from tests.processes import PATIENCE_S, ended, started, until


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
