"""The virtual rig speaks on the bus exactly what the DBC says, in the right order and at the right time."""

import csv
from pathlib import Path
from unittest import mock

import can
import cantools
import numpy as np
import pytest

import drivers
from drivers.virtual_rig import Run, frame_table, play, simulate, write
from drivers.virtual_rig.frames.frames import EPOCH_S
from tests.log_fake import crc

DBC = cantools.database.load_file(Path(drivers.__file__).with_name("rig.dbc"), strict=True)


@pytest.fixture(scope="module")
def run() -> Run:
    """20 s at rest, some strokes of FS-20, rest again."""
    return simulate("FS-20", cycles=1, max_drive_s=4.0, stop_s=30.0, plant={"support_yield": 1.0})


@pytest.fixture(scope="module")
def sent(run) -> list[can.Message]:
    return list(frame_table(run).messages())


def of(sent: list[can.Message], name: str) -> list[can.Message]:
    frame_id = DBC.get_message_by_name(name).frame_id
    return [message for message in sent if message.arbitration_id == frame_id]


def signals(sent: list[can.Message], name: str) -> list[dict]:
    frame = DBC.get_message_by_name(name)
    return [frame.decode(message.data, decode_choices=False, allow_excess=False) for message in of(sent, name)]


def test_every_payload_is_what_cantools_encodes(sent):
    for message in sent:
        frame = DBC.get_message_by_frame_id(message.arbitration_id)
        told = frame.decode(message.data, decode_choices=False, allow_excess=False)
        assert frame.encode(told, strict=True) == bytes(message.data)
        assert frame.length == message.dlc


def test_decoded_temperatures_are_the_measured_ones(run, sent):
    shown = {}
    for name in ("Telemeter1", "Telemeter2", "Telemeter3", "Telemeter4"):
        rows = signals(sent, name)
        shown |= {signal: [row[signal] for row in rows] for signal in rows[0]}
    columns = np.column_stack([shown[f"T{n:02d}"] for n in range(1, 16)])
    assert columns == pytest.approx(run.measured.channels, abs=1e-9)
    assert shown["TBoard"] == pytest.approx(run.measured.board.tolist(), abs=1e-9)
    both = zip(signals(sent, "Environment1"), signals(sent, "Environment2"), strict=True)
    around = [first | second for first, second in both]
    order = ("EnvAmbient", "EnvBase", "EnvBracketAnchor", "EnvBracketFree", "EnvNut", "EnvProbe", "EnvBar")
    for signal, column in zip(order, run.measured.environment, strict=True):
        assert [row[signal] for row in around] == pytest.approx(column.tolist(), abs=1e-9)


def test_decoded_displacement_is_the_reading(run, sent):
    for name, prefix, reading in (
        ("DisplacementHold", "DspHold", run.holds.reading),
        ("DisplacementDirect", "DspDirect", run.measured.direct),
    ):
        rows = signals(sent, name)
        assert [row[f"{prefix}A1B1"] for row in rows] == pytest.approx(reading.a1b1.tolist(), abs=6e-4)
        assert [row[f"{prefix}A2B2"] for row in rows] == pytest.approx(reading.a2b2.tolist(), abs=6e-4)
        assert [row[f"{prefix}State"] for row in rows] == reading.state.tolist()
        assert [row[f"{prefix}Seq"] for row in rows] == [k % 256 for k in range(len(rows))]


def test_decoded_drive_is_the_motion(run, sent):
    rows = signals(sent, "Drive")
    times = np.array([message.timestamp - EPOCH_S for message in of(sent, "Drive")])
    motion = run.motion(np.round(times, 2))
    assert [row["DrvPosition"] for row in rows] == pytest.approx(motion.position_mm.tolist(), abs=6e-5)
    assert [row["DrvSpeed"] for row in rows] == pytest.approx(motion.speed_rpm.tolist(), abs=0.06)
    assert [row["DrvState"] == 2 for row in rows] == motion.moving.tolist()
    assert {row["DrvState"] for row in rows} == {1, 2}


def test_current_carries_friction_and_acceleration(run):
    times = np.arange(20.0, 24.0, 0.01)
    drive, motion = run.drive(times), run.motion(times)
    steady = motion.acceleration_mm_s2 == 0
    assert np.abs(drive.current_a[steady]).mean() == pytest.approx(1.8, abs=0.6)
    assert np.abs(drive.current_a[~steady]).max() > 5.0


def test_drive_comes_each_10_ms_moving_and_each_second_at_rest(run, sent):
    times = np.array([message.timestamp - EPOCH_S for message in of(sent, "Drive")])
    (drive,) = run.travel.drives
    moving = (times >= drive.start_s) & (times < drive.stop_s)
    assert np.diff(times[moving]) == pytest.approx(0.01, abs=1e-6)
    assert np.diff(times[times <= drive.start_s]) == pytest.approx(1.0, abs=1e-6)
    assert np.diff(times[times > drive.stop_s + 1.0]) == pytest.approx(1.0, abs=1e-6)


def test_counters_run_from_0_to_14(sent):
    for name, counter in (("TelemeterStatus", "TelCounter"), ("Drive", "DrvCounter"), ("Environment2", "EnvCounter")):
        counted = [row[counter] for row in signals(sent, name)]
        assert counted == [k % 15 for k in range(len(counted))]


def test_status_checks_itself_and_its_scan(sent):
    blocks = [of(sent, name) for name in ("Telemeter1", "Telemeter2", "Telemeter3", "Telemeter4")]
    closing = zip(signals(sent, "TelemeterStatus"), of(sent, "TelemeterStatus"), strict=True)
    for k, (status, message) in enumerate(closing):
        scan = b"".join(bytes(block[k].data) for block in blocks)
        assert status["TelScanCrc"] == crc(scan, 0x1021, 16, 0xFFFF, 0)
        covered = bytes([0x14, 0x02]) + bytes(message.data[1:])
        assert status["TelCrc"] == crc(covered, 0x1D, 8, 0xFF, 0xFF)
        assert (status["TelScanNo"], status["TelState"], status["TelFaultMask"]) == (k, 1, 0)


def test_each_tick_closes_with_the_status(sent):
    """Between two status frames lie one frame of each 1 s message, all stamped within 3 ms."""
    slow = {0x210, 0x211, 0x212, 0x213, 0x221, 0x240, 0x241}
    seen: dict[int, float] = {}
    for message in sent:
        if message.arbitration_id in slow:
            assert message.arbitration_id not in seen
            seen[message.arbitration_id] = message.timestamp
        elif message.arbitration_id == 0x214:
            assert set(seen) == slow
            assert message.timestamp - min(seen.values()) < 0.003
            seen = {}
    assert not seen


def test_frames_are_ordered_and_start_at_the_epoch(sent):
    times = np.array([message.timestamp for message in sent])
    assert times[0] == EPOCH_S
    assert np.all(np.diff(times) >= 0.0)


@pytest.mark.parametrize("suffix", [".log", ".blf", ".asc", ".trc", ".csv"])
def test_recordings_read_back_as_sent(run, sent, tmp_path, suffix):
    path = write(run, tmp_path / f"made{suffix}")
    with can.LogReader(str(path), **({"relative_timestamp": False} if suffix == ".asc" else {})) as reader:
        back = [message for message in reader if not message.is_error_frame]
    assert [(m.arbitration_id, bytes(m.data)) for m in back] == [(m.arbitration_id, bytes(m.data)) for m in sent]
    elapsed = np.array([m.timestamp for m in back]) - back[0].timestamp
    assert elapsed == pytest.approx(np.array([m.timestamp - EPOCH_S for m in sent]), abs=1.1e-3)


def test_log_lines_are_plain_candump(run, tmp_path):
    first = write(run, tmp_path / "made.log").read_text().splitlines()[0]
    assert first.startswith("(1700000000.000000) can0 230#")
    assert len(first.split("#")[1]) == 16


def test_truth_lies_beside_the_recording_on_the_log_s_clock(run, sent, tmp_path):
    write(run, tmp_path / "made.blf")
    with (tmp_path / "made.truth.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    table = [f"table_{at}_um" for at in range(0, 401, 50)]
    assert list(rows[0]) == ["time_s", "elongation_um", *(f"T{n:02d}" for n in range(1, 16)), *table]
    closing = [message.timestamp - sent[0].timestamp for message in of(sent, "TelemeterStatus")]
    assert [float(row["time_s"]) for row in rows] == pytest.approx(closing, abs=1e-4)
    assert [float(row["elongation_um"]) for row in rows] == pytest.approx(run.truth.elongation_um.tolist(), abs=1e-5)
    assert [float(row["T12"]) for row in rows] == pytest.approx(run.truth.rises[:, 11].tolist(), abs=1e-5)
    assert [float(row["table_400_um"]) for row in rows] == pytest.approx(run.truth.table_um[:, 8].tolist(), abs=1e-5)


def test_play_keeps_the_rig_s_time_without_drift():
    run = simulate("FS-20", seconds=24.0)
    speed_up = 20.0
    due = list(frame_table(run).messages())
    clock, sent = [500.0], []

    def sleep(seconds: float) -> None:
        clock[0] += seconds + 0.003  # every sleep is too long

    def send(message: can.Message) -> None:
        sent.append((message.arbitration_id, clock[0]))
        clock[0] += 20e-6

    steady = mock.Mock(monotonic=lambda: clock[0], sleep=sleep)
    with mock.patch("drivers.virtual_rig.frames.player.time", steady):
        play(frame_table(run).messages(0.0), mock.Mock(send=send), speed_up)
    assert [arbitration_id for arbitration_id, _ in sent] == [message.arbitration_id for message in due]
    late = np.array([at for _, at in sent]) - [500.0 + (m.timestamp - EPOCH_S) / speed_up for m in due]
    assert late.min() >= -1e-6
    assert late.max() < 0.01
