"""Frames of a bus as a CSV."""

from pathlib import Path

import numpy as np
import pytest

from drivers.frames import Tally
from drivers.logs.every_frame import every_frame
from drivers.recordings import read_recording
from estimator.errors import InputError
from tests import log_fake
from tests.conftest import RIG

ROWS = log_fake.log(8)
SAVVY = "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8"
EDGE = "TimestampEpoch;BusChannel;ID;IDE;DLC;DataLength;Dir;EDL;BRS;DataBytes"


def savvy(row: log_fake.Row) -> str:
    octets = ",".join(f"{byte:02X}" for byte in row.data)
    return f"{row.time * 1e6:.0f},{row.id:08X},{str(row.extended).lower()},Rx,0,{len(row.data)},{octets},"


def edge(row: log_fake.Row) -> str:
    size = len(row.data)
    return f"{row.time:.6f};1;{row.id:X};{int(row.extended)};{size};{size};0;0;0;{row.data.hex().upper()}"


@pytest.mark.parametrize(("head", "line"), [(SAVVY, savvy), (EDGE, edge)])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_frames_are_read_and_passed_on(tmp_path: Path, head: str, line, encoding: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text("\n".join([head, *map(line, ROWS), ""]), encoding=encoding)
    record, same = read_recording(path, RIG), read_recording(log_fake.write(tmp_path / "b.log", ROWS), RIG)
    np.testing.assert_array_equal(record.channels, same.channels)
    np.testing.assert_allclose(record.time_s, same.time_s, atol=1e-5)
    assert record.frames == same.frames
    frames = list(every_frame(path, Tally()))
    assert [(f.id, f.extended, f.data) for f in frames] == [(r.id, r.extended, r.data) for r in ROWS]


def test_lines_that_hold_no_frame_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    fd = f"{ROWS[0].time + 1:.6f};1;210;0;15;64;0;1;0;{'00' * 64}"
    path.write_text("\n".join([EDGE, *map(edge, ROWS), fd, "x;1;210;0;8;8;0;0;0;00", "5;1;210;0;8;8;0;0;0;0", ""]))
    skipped = read_recording(path, RIG).skipped
    assert (skipped["CAN FD frame"], skipped["torn or foreign line"]) == (1, 2)


@pytest.mark.parametrize(
    "names",
    ["Time,Chn,Identifier,DLC,Data", "Timestamp;Type;ID;Data", "id,dlc,data0,data1,data2,time", "CAN ID,Len,Byte1"],
)
def test_frames_of_another_program_are_said_to_be_frames(tmp_path: Path, names: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"{names}\n1,2,3,4,5\n")
    with pytest.raises(InputError, match="frames in a CSV of another kind"):
        read_recording(path, RIG)


@pytest.mark.parametrize(
    "line",
    [
        " ({:.6f})  can0  {}   [{}]  {}",
        "  can0  {1}   [{2}]  {3}",
        " (2023-11-14 22:13:20.000000)  can0  RX - -  {1}   [{2}]  {3}   '........'",
    ],
)
def test_what_candump_shows_on_the_screen_is_refused_with_the_way_to_record(tmp_path: Path, line: str) -> None:
    path = tmp_path / "a.log"
    lines = [line.format(r.time, f"{r.id:03X}", len(r.data), r.data.hex(" ").upper()) for r in ROWS]
    path.write_text("\n".join([*lines, ""]))
    with pytest.raises(
        InputError, match=f"{len(ROWS)} x line as candump shows it on the screen: record with `candump -L`"
    ):
        read_recording(path, RIG)


@pytest.mark.parametrize("start", [0.0, 1_700_000_000.0])
@pytest.mark.parametrize(
    ("text", "said"),
    [
        (lambda s: f"{s * 1e3:.0f}", "milliseconds"),
        (lambda s: f"{s * 1e3:.3f}", "milliseconds"),
        (lambda s: f"{s * 1e6:.0f}", ""),
        (lambda s: f"{s:.6f}", ""),
    ],
)
def test_what_the_stamps_of_savvycan_count(tmp_path: Path, start: float, text, said: str) -> None:
    first = ROWS[0].time
    rows = [row._replace(time=row.time - first + start) for row in ROWS]
    path = tmp_path / "a.csv"
    lines = [f"{text(row.time)},{savvy(row).partition(',')[2]}" for row in rows]
    path.write_text("\n".join([SAVVY, *lines, ""]))
    record, same = read_recording(path, RIG), read_recording(log_fake.write(tmp_path / "b.log", rows), RIG)
    np.testing.assert_array_equal(record.channels, same.channels)
    np.testing.assert_allclose(record.time_s, same.time_s, atol=2e-3)
    assert any(said in note for note in record.notes) == bool(said)


def test_stamps_of_several_busy_buses_count_us(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    lines = [f"{k * 20},00000100,false,Rx,{k % 7},0," for k in range(700)]
    path.write_text("\n".join([SAVVY, *lines, ""]))
    assert max(frame.time_s for frame in every_frame(path, Tally())) == pytest.approx(699 * 20e-6)


def test_stamps_that_are_none_do_not_tell_the_unit(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    odd = ["inf" + savvy(ROWS[0])[savvy(ROWS[0]).index(",") :], "nan" + savvy(ROWS[1])[savvy(ROWS[1]).index(",") :]]
    path.write_text("\n".join([SAVVY, *odd, *map(savvy, ROWS), ""]))
    record = read_recording(path, RIG)
    assert (record.frames, record.skipped["time stamp is no number"]) == (len(ROWS), 2)


def test_a_canedge_with_commas_in_its_times(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("\n".join([EDGE, *(edge(row).replace(".", ",", 1) for row in ROWS), ""]))
    assert read_recording(path, RIG).frames == len(ROWS)
