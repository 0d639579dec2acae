"""The reader in a process of its own is ended where it loops, inflates or dies."""

import re
import struct
import zlib
from pathlib import Path
from queue import Queue

import numpy as np

from drivers.budget import Budget
from drivers.frames import Tally
from drivers.logs import outside
from drivers.logs.logs import read_log
from drivers.recordings import read_recording
from tests import log_fake
from tests.drivers.decode.test_ticks import RIG
from tests.drivers.logs.test_logs import ROWS, complaint, make


def container(inner: bytes, method: int = 0) -> bytes:
    body = struct.pack("<H6xL4x", method, len(inner)) + inner
    return struct.pack("<4sHHLL", b"LOBJ", 16, 1, 16 + len(body), 10) + body


def test_a_reader_that_loops_is_ended_and_its_frames_kept(tmp_path: Path) -> None:
    whole = make(tmp_path / "whole.blf").read_bytes()
    looping = container(struct.pack("<4sHHLL", b"LOBJ", 16, 9, 0, 1))
    path = tmp_path / "loop.blf"
    path.write_bytes(whole[:144] + looping)
    assert complaint(path, budget=Budget(stall_s=0.5)) == (
        f"{path}: 0 usable frames (192 bytes; stopped after 0 frames: the reader gave no frame for 1 s); "
        "expected a Vector BLF log"
    )
    path.write_bytes(whole + looping)
    record = read_recording(path, RIG, budget=Budget(stall_s=0.5))
    assert record.frames == len(ROWS)
    assert record.notes == (f"stopped after {len(ROWS)} frames: the reader gave no frame for 1 s",)


def answer(tmp_path: Path, *used_s: float, frames: int = 0) -> str:
    """What is noted of a reader that has used so much processor time at each of its reports."""
    blocks: Queue[outside.Block] = Queue()
    for seconds in used_s:
        blocks.put(outside.Block(b"F", frames, 0.0, seconds, b""))
    blocks.put(outside.Block(b"A", 0, 1.0, 0.0, b'{"found": "all", "skipped": {}, "notes": [], "buses": []}'))
    reading = outside.Outside(make(tmp_path / "a.blf"), tally := Tally(), Budget(stall_s=1.0, seconds=20.0), "classic")
    list(reading.within_budget(blocks))
    return reading.found if reading.found == "all" else tally.notes[-1]


def test_a_reader_is_judged_by_its_own_processor_time(tmp_path: Path) -> None:
    """However long a busy machine lets it wait, and however long it takes to start."""
    assert answer(tmp_path, 30.0, 30.5, 30.9) == "all"
    assert answer(tmp_path, 0.5, 1.0, 1.6) == "stopped after 0 frames: the reader gave no frame for 1 s"
    assert answer(tmp_path, 0.5, 1.2, 1.9, frames=1) == "all"
    assert answer(tmp_path, 0.5, *np.arange(1.0, 22.0), frames=1) == "stopped after 22 frames: reading took 20 s"


def endless(path: Path, version: int = 1) -> Path:
    """A BLF of 240 bytes that gives the same frame for ever, for its length is 0; of version 9 it gives none."""
    message = struct.pack("<4sHHLLLHHQHBBL8s", b"LOBJ", 32, version, 0, 1, 2, 0, 0, 0, 1, 0, 8, 0x123, bytes(8))
    path.write_bytes(make(path.with_name("whole.blf")).read_bytes()[:144] + container(message + bytes(16)))
    return path


def test_a_small_file_that_gives_frames_for_ever_is_ended(tmp_path: Path) -> None:
    path = endless(tmp_path / "endless.blf")
    assert path.stat().st_size == 240
    frames = read_log(path, tally := Tally(), Budget())
    assert 24_000 < len(frames) < 1_000_000
    assert tally.notes[-1].endswith(" frames: 240 bytes cannot hold more, the reader goes round in circles")


def test_a_file_that_inflates_is_ended(tmp_path: Path) -> None:
    head = make(tmp_path / "whole.blf").read_bytes()[:144]
    path = tmp_path / "bomb.blf"
    path.write_bytes(head + container(zlib.compress(bytes(400_000_000), 1), 2))
    assert re.search(r"0 usable frames \(.*out of memory", complaint(path, budget=Budget(memory=300_000_000)))


def test_budgets(tmp_path: Path) -> None:
    path = log_fake.write(tmp_path / "a.log", ROWS)
    record = read_recording(path, RIG, budget=Budget(frames=100))
    assert record.notes == (f"stopped at line {len(ROWS)}: 100 frames are the most that one recording may hold",)
    record = read_recording(make(tmp_path / "a.blf"), RIG, budget=Budget(frames=100))
    assert "100 frames are the most" in record.notes[0]
    assert "stopped after 0 frames: reading took 0 s" in complaint(tmp_path / "a.blf", budget=Budget(seconds=0.0))
