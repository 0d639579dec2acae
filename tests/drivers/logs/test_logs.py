"""Logs of every format: round trips, and what each kind of bad file becomes."""

import os
import random
import sys
from pathlib import Path
from unittest import mock

import can
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from drivers.budget import Budget
from drivers.frames import Tally
from drivers.logs.candump import read_candump
from drivers.logs.logs import read_log
from drivers.recordings import find_recordings, read_recording
from estimator.errors import InputError
from tests import log_fake
from tests.drivers.decode.test_ticks import RIG, assert_same

ROWS = log_fake.log(12, 10, (3, 9))
CANDUMP = 'candump text like "(1699999999.123456) can0 210#0011223344556677"'


def make(path: Path, rows: list[log_fake.Row] = ROWS) -> Path:
    """A log in the format of the suffix, by python-can's writers."""
    with can.Logger(path) as writer:
        for row in rows:
            message = can.Message(
                timestamp=row.time, arbitration_id=row.id, is_extended_id=row.extended, data=row.data, channel=0
            )
            writer.on_message_received(message)
    return path


def complaint(path: Path, **options) -> str:
    with pytest.raises(InputError) as error:
        read_recording(path, RIG, **options)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize("suffix", [".log", ".blf", ".asc", ".trc", ".csv"])
def test_every_format_gives_the_same_recording(tmp_path: Path, suffix: str) -> None:
    expected = read_recording(log_fake.write(tmp_path / "expected.log", ROWS), RIG)
    shares: list[float] = []
    record = read_recording(make(tmp_path / f"run{suffix}"), RIG, progress=shares.append)
    assert record.name == f"run{suffix}"
    assert record.frames == len(ROWS)
    assert record.skipped == expected.skipped
    assert record.notes == ()
    np.testing.assert_array_equal(record.channels, expected.channels)
    # .trc and .asc keep less of the time
    np.testing.assert_allclose(record.time_s, expected.time_s, atol=2e-3)
    np.testing.assert_allclose(record.coverage, expected.coverage, atol=0.03)
    assert all(0 <= share <= 1 for share in shares)


FRAME = st.builds(
    log_fake.Row,
    st.integers(0, 4_000_000_000_000_000).map(lambda us: us / 1e6),
    st.integers(0, 0x7FF),
    st.just(False),
    st.binary(max_size=8),
)

LONG = st.builds(lambda row, number: row._replace(id=number, extended=True), FRAME, st.integers(0, 0x1FFFFFFF))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(rows=st.lists(st.one_of(FRAME, LONG), min_size=1, max_size=80))
def test_candump_text_comes_back(tmp_path: Path, rows: list[log_fake.Row]) -> None:
    frames, _ = read_candump(log_fake.write(tmp_path / "a.log", rows), tally := Tally(), Budget())
    back = zip(frames.time.tolist(), frames.id.tolist(), frames.extended.tolist(), frames.dlc, frames.data, strict=True)
    # 0x20000000 marks an error frame; a 29-bit id never has it
    assert [log_fake.Row(t, i, e, d[:n].tobytes()) for t, i, e, n, d in back] == rows
    assert frames.number.tolist() == list(range(1, len(rows) + 1))
    assert not tally.skipped


def test_no_cut_gives_a_shortened_frame(tmp_path: Path) -> None:
    text = log_fake.text(ROWS).encode()
    known = {(row.id, row.data) for row in ROWS}
    draw = random.Random(7)
    for _ in range(200):
        path = tmp_path / "cut.log"
        cut = draw.randrange(len(text) // 10, len(text))
        start = draw.choice([0, draw.randrange(cut)])
        path.write_bytes(text[start:cut] + bytes(draw.choice([0, 4096])))
        frames, _ = read_candump(path, Tally(), Budget())
        pairs = zip(frames.id.tolist(), frames.dlc, frames.data, strict=True)
        assert {(number, data[:size].tobytes()) for number, size, data in pairs} <= known


def test_a_torn_end_is_said(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    path.write_text(log_fake.text(ROWS)[:-9])
    record = read_recording(path, RIG)
    assert record.notes == (f"torn at line {len(ROWS)}: it has no line end; read up to there",)
    assert len(record) == 11
    path.write_bytes(log_fake.text(ROWS)[:-9].encode() + bytes(4096))
    assert "4096 bytes of it zero" in read_recording(path, RIG).notes[0]


def test_what_is_no_data_frame_is_counted(tmp_path: Path) -> None:
    lines = log_fake.text(ROWS).splitlines(keepends=True)
    stamp = lines[40].split()[0]
    odd = [
        "can0  210   [8]  00 11\n",
        f"{stamp} can0 210#R\n",
        f"{stamp} can0 210##1112233\n",
        "\n",
        f"{stamp} can0 20000040#0004000000000000\n",
        f"{stamp} can0 21#00\n",
        f"{stamp} can0 FFF#00\n",
        f"{stamp} can0 210#001\n",
    ]
    path = tmp_path / "a.log"
    path.write_text("".join([*lines[:40], *odd, *lines[40:]]))
    record = read_recording(path, RIG)
    assert record.skipped == {
        "torn or foreign line": 3,
        "remote frame": 1,
        "CAN FD frame": 1,
        "error frame": 1,
        "impossible id": 1,
        "held since before the log displacement_direct": 1,
    }
    assert record.notes == ("line 41 is no frame (the first of 3)",)
    assert_same(record, read_recording(log_fake.write(path, ROWS), RIG))


def test_windows_line_ends_and_directions(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    text = log_fake.text(ROWS)
    path.write_bytes(text.replace("\n", " R\r\n").encode())
    assert_same(read_recording(path, RIG), read_recording(log_fake.write(tmp_path / "b.log", ROWS), RIG))


def test_two_interfaces_are_said(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    path.write_text(log_fake.text(ROWS).replace("can0 24", "can1 24"))
    assert read_recording(path, RIG).notes == ("the rig's messages come on can0 and can1",)


def test_files_that_are_no_log(tmp_path: Path) -> None:
    def file(name: str, content: bytes) -> Path:
        (tmp_path / name).write_bytes(content)
        return tmp_path / name

    assert complaint(tmp_path / "no.log") == f"{tmp_path / 'no.log'}: no such file"
    assert complaint(tmp_path).startswith(f"{tmp_path}: no known kind of log ''; known: .asc, .blf")
    known = "known: .asc, .blf, .csv, .log, .mf4, .trc"
    assert complaint(path := file("a.xyz", b"")) == f"{path}: no known kind of log '.xyz'; {known}"
    assert complaint(path := file("a.log", b"")) == f"{path}: 0 usable frames (0 lines read); expected {CANDUMP}"
    assert complaint(path := file("b.log", b"Jan 1 kernel: hello\n" * 12)) == (
        f"{path}: 0 usable frames (12 lines read; 12 x torn or foreign line; line 1 is no frame (the first of 12)); "
        f"expected {CANDUMP}"
    )
    assert complaint(path := file("c.log", bytes(1000))).startswith(
        f"{path}: 0 usable frames (1 lines read; 1 x torn line; "
    )
    assert complaint(path := file("a.blf", b"no blf at all" * 9)) == (
        f"{path}: 0 usable frames (117 bytes; torn at frame 1: BLFParseError: Unexpected file format; "
        "read up to there); expected a Vector BLF log"
    )
    assert complaint(path := file("a.asc", b"some text\n" * 3)) == (
        f"{path}: 0 usable frames (3 lines read; 3 x line without a frame); expected a Vector ASC log; a "
        "table as text is read as .csv: rename it"
    )
    assert "expected a PEAK TRC log" in complaint(file("a.trc", b"some text\n" * 3))
    with mock.patch("drivers.logs.logs.find_spec", return_value=None):
        why = "reading MF4 needs asammdf: pip install 'ballscrew[mf4]'"
        assert complaint(path := file("a.mf4", b"MDF")) == f"{path}: {why}"
    path = log_fake.write(tmp_path / "d.log", ROWS[:3])
    assert complaint(path) == f"{path}: 3 frames over 0.99 s, less than one tick of 1 s"
    path = log_fake.write(tmp_path / "e.log", [row._replace(id=0x100 + row.id % 6, extended=True) for row in ROWS])
    assert complaint(path) == (
        f"{path}: 168 frames, none of this rig: ids 0x00000100, 0x00000101, 0x00000102, 0x00000103 and 2 more; "
        "expected 0x210 (Telemeter1), 0x211 (Telemeter2), 0x212 (Telemeter3), 0x213 (Telemeter4) and 6 more "
        "as in rig.dbc"
    )
    os.mkfifo(tmp_path / "pipe.log")
    assert complaint(tmp_path / "pipe.log") == f"{tmp_path / 'pipe.log'}: not a regular file"


def test_a_line_that_is_too_long_is_one_line(tmp_path: Path) -> None:
    path = make(tmp_path / "a.asc")
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join([*lines[:40], "x" * 10_000 + "\n", *lines[40:]]))
    record = read_recording(path, RIG)
    assert record.frames == len(ROWS)
    assert record.skipped["line without a frame"] == 1
    assert record.notes == ()


def test_absurd_stamps(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    text = make(path).read_text().splitlines(keepends=True)
    stamps = ["nan", "inf", "-1.0", "1e300"]
    extra = [",".join([stamp, *text[20].split(",")[1:]]) for stamp in stamps]
    path.write_text("".join([*text[:20], *extra, *text[20:]]))
    record = read_recording(path, RIG)
    assert record.skipped["time stamp is no number"] == 2
    assert record.skipped["time stamp absurd"] == 2
    assert len(record) == 12


@pytest.mark.parametrize("suffix", [".asc", ".trc", ".csv", ".blf"])
def test_a_cut_file_is_read_up_to_the_cut(tmp_path: Path, suffix: str) -> None:
    path = make(tmp_path / f"a{suffix}")
    path.write_bytes(path.read_bytes()[: -path.stat().st_size // 3].rstrip(b"\r\n"))  # never at the end of a line
    record = read_recording(path, RIG)
    assert 5 <= len(record) < 12
    assert any(note.startswith("torn") for note in record.notes), record.notes
    known = {(row.id, row.data) for row in ROWS}
    frames = read_log(path, Tally(), Budget())
    assert {(i, d[:n].tobytes()) for i, n, d in zip(frames.id.tolist(), frames.dlc, frames.data, strict=True)} <= known


def test_recordings_in_a_folder(tmp_path: Path) -> None:
    for name in ("b.log", "a.blf", "a.truth.csv", "rig.toml", "notes.txt", "C.CSV"):
        (tmp_path / name).touch()
    found = find_recordings([tmp_path, tmp_path / "b.log", tmp_path / "odd.xyz", tmp_path / "a.truth.csv"])
    assert [path.name for path in found] == ["C.CSV", "a.blf", "b.log", "odd.xyz"]
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="empty: no recording in this folder; expected files "):
        find_recordings([tmp_path / "empty"])
    assert complaint(tmp_path / "a.truth.csv").endswith("the truth of a simulated recording, not a recording")


def test_a_table_that_review_wrote_beside_recordings_is_none_of_them(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text('"time_s","mode","elongation_um","sigma_um"\n0,"predict",0,0\n')
    (tmp_path / "b.csv").write_text('"recording","time_s","mode"\n"a.log",0,"predict"\n')
    (tmp_path / "c.csv").write_text('"time_s","T01"\n0,20\n')
    assert [path.name for path in find_recordings([tmp_path])] == ["c.csv"]
    assert complaint(tmp_path / "a.csv").endswith("what `review --table` has written of a recording, not a recording")


def test_a_long_log_is_read_in_bulk(tmp_path: Path) -> None:
    """Whoever calls something for every frame needs minutes for a day."""
    path = tmp_path / "long.log"
    rows = log_fake.log(20, 100)
    with path.open("w") as file:
        for k in range(36):
            file.write(log_fake.text([row._replace(time=row.time + 20 * k) for row in rows]))
    read_recording(path, RIG)  # a rig's DBC is read once
    events: list[str] = []
    sys.setprofile(lambda _frame, event, _argument: events.append(event))
    try:
        record = read_recording(path, RIG)
    finally:
        sys.setprofile(None)
    assert len(record) == 720
    assert len(events) < record.frames / 2  # calls and returns, of C too


def test_a_byte_order_mark_is_no_part_of_the_first_line(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    path.write_text(log_fake.text(ROWS), encoding="utf-8-sig")
    record = read_recording(path, RIG)
    assert_same(record, read_recording(log_fake.write(tmp_path / "b.log", ROWS), RIG))
    assert "torn or foreign line" not in record.skipped
