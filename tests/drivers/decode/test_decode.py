"""Decoding: checksums, counters and scans; what makes a value unusable; another DBC without code."""

from pathlib import Path

import can
import cantools
import numpy as np
import pytest

from drivers.decode.checks import crc8_j1850, crc16_ccitt_false, lost
from drivers.decode.dbc import Bits, load_dbc
from drivers.recordings import read_recording
from estimator.rig_folder.rig_folder import load_rig
from tests import log_fake
from tests.conftest import PAPER, RIG


def words(data: list[bytes]):
    table = np.frombuffer(b"".join(data), np.uint8).reshape(len(data), 8)
    return table.view("<u8")[:, 0], table.view(">u8")[:, 0].astype(np.uint64)


def test_checksums_of_the_catalogue() -> None:
    digits = np.frombuffer(b"123456789", np.uint8)[None]
    assert crc8_j1850(digits)[0] == 0x4B
    assert crc16_ccitt_false(digits)[0] == 0x29B1


def test_lost_frames_by_counter() -> None:
    assert lost(np.array([13, 14, 0, 3]), 12, 15) == 2
    assert lost(np.array([1, 3, 2, 4]), 0, 15) == 0  # out of order, none lost


@pytest.mark.parametrize(
    ("bits", "numbers"),
    [
        (Bits("eight", 0, 8), [254, 255, 0, 1]),
        (Bits("eight", 0, 8, highest=255.0), [254, 255, 0, 1]),
        (Bits("four", 0, 4, highest=14.0), [13, 14, 0, 1]),
        (Bits("four", 4, 4, highest=99.0), [14, 15, 0, 1]),
        (Bits("signed", 0, 8, signed=True, highest=127.0), [126, 127, 128, 129, 255, 0]),
        (Bits("wide", 0, 64), [7, 8]),
    ],
)
def test_a_counter_starts_again_by_its_maximum_or_its_width(bits: Bits, numbers: list[int]) -> None:
    frames = [(number << bits.shift).to_bytes(8, "little") for number in numbers]
    counted = bits.count(words(frames))
    assert counted.tolist() == numbers
    assert lost(counted[1:], int(counted[0]), bits.modulus) == (125 if bits.signed else 0)


def test_a_scaled_maximum_is_no_number_on_the_wire(tmp_path: Path) -> None:
    (tmp_path / "a.dbc").write_text('VERSION ""\nBU_: A\nBO_ 18 M: 8 A\n SG_ N : 0|8@1+ (0.5,-1) [-1|6] "" A\n')
    assert load_dbc(tmp_path / "a.dbc").messages["M"].signals["N"].modulus == 15


def altered(tmp_path: Path, scan: int, change) -> object:
    """The recording of a log of which one scan's frames are changed."""
    rows = log_fake.log(8, 5, (2, 6))
    begin = log_fake.START + scan
    rows = [new for row in rows for new in ([row] if not begin <= row.time < begin + 1 else change(row))]
    return read_recording(log_fake.write(tmp_path / "a.log", rows), RIG)


def patched(message_id: int, at: int, new: bytes):
    return lambda row: (
        [row._replace(data=row.data[:at] + new + row.data[at + len(new) :])] if row.id == message_id else [row]
    )


@pytest.mark.parametrize(
    ("change", "reason", "gone"),
    [
        (patched(0x211, 4, b"\x00\x80"), "scan checksum wrong", range(15)),
        (patched(0x214, 3, b"\x77"), "checksum wrong TelemeterStatus", []),
        (
            lambda row: [] if row.id == 0x212 else [row],
            "scan incomplete, its checksum not checked (used)",
            range(8, 12),
        ),
        (
            lambda row: [row._replace(data=row.data[:6])] if row.id == 0x212 else [row],
            "wrong length Telemeter3",
            range(8, 12),
        ),
        (patched(0x220, 1, b"\x02"), "flagged OverRange displacement", [15]),
        (patched(0x220, 2, b"\x00\x00\x7f"), "out of range displacement", [15]),
        (patched(0x240, 0, b"\x00\x80"), "not available ambient", []),
        (patched(0x240, 0, b"\x01\x80"), "sensor fault ambient", []),
        (patched(0x240, 0, b"\x00\x7f"), "out of range ambient", []),
    ],
)
def test_unusable_is_nan_and_counted(tmp_path: Path, change, reason: str, gone) -> None:
    record = altered(tmp_path, 4, change)
    assert reason in record.skipped
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(record.channels[4])), list(gone))
    assert np.isnan(record.inputs["ambient"][4]) == reason.endswith("ambient")


@pytest.mark.parametrize(
    ("state", "faults", "reason", "gone"),
    [
        (2, 0, "scan with TelState LowSupply", range(15)),
        (9, 0, "scan with TelState unknown", range(15)),
        (1, 0b1000001, "fault bit T07", [0, 6]),
        (1, 1 << 15, "fault bit TBoard", []),
    ],
)
def test_scan_says_itself_what_counts(tmp_path: Path, state: int, faults: int, reason: str, gone) -> None:
    rows = [row for row in log_fake.log(6, 5) if row.id != 0x214 and not 0x210 <= row.id < 0x214]
    for k in range(6):
        rows += log_fake.telemeter(log_fake.START + k + 0.995, k, 20, *((state, faults) if k == 2 else (1, 0)))
    record = read_recording(log_fake.write(tmp_path / "a.log", sorted(rows, key=lambda row: row.time)), RIG)
    assert record.skipped[reason] == 1
    bad = np.isnan(record.channels[:, :15])
    np.testing.assert_array_equal(np.flatnonzero(bad[2]), list(gone))
    assert not np.delete(bad, 2, axis=0).any()
    assert np.isnan(record.inputs["board"][2]) == (15 in [*gone] or faults == 1 << 15 or state != 1)


SEVEN_DBC = """VERSION ""
BU_: Logger
BO_ 2566834688 Spindle: 8 Logger
 SG_ Temp1 : 7|16@0- (0.1,0) [0|0] "degC" Logger
 SG_ Temp2 : 23|16@0- (0.1,0) [0|0] "degC" Logger
 SG_ Temp3 : 39|16@0- (0.1,0) [0|0] "degC" Logger
 SG_ Temp4 : 55|16@0- (0.1,0) [0|0] "degC" Logger
BO_ 257 Rest: 8 Logger
 SG_ Temp5 : 7|16@0- (0.1,0) [0|0] "degC" Logger
 SG_ Temp6 : 23|16@0- (0.1,0) [0|0] "degC" Logger
 SG_ Temp7 : 39|16@0- (0.1,0) [0|0] "degC" Logger
BO_ 258 Axis: 6 Logger
 SG_ Place : 0|32@1- (0.001,0) [0|0] "mm" Logger
BO_ 259 Motor: 4 Logger
 SG_ Rate : 0|32@1- (1,0) [0|0] "rad/s" Logger
VAL_ 257 Temp7 32767 "n/a" ;
SIG_VALTYPE_ 259 Rate : 1;
"""


def test_seven_channels_on_another_dbc(tmp_path: Path) -> None:
    (tmp_path / "seven.dbc").write_text(SEVEN_DBC)
    signals = [f"Spindle.Temp{n}" for n in range(1, 5)] + [f"Rest.Temp{n}" for n in range(5, 8)]
    channels = "\n".join(f'C{n} = {{ at_mm = {100 * n}, signal = "{s}" }}' for n, s in enumerate(signals, 1))
    (tmp_path / "rig.toml").write_text(
        'name = "seven"\ntick_s = 0.5\n[screw]\nfrom_mm = 0\nto_mm = 800\nouter_mm = 32\n'
        "[nut]\nlength_mm = 80\ncentre_mm = 100\ndirection = 1\n"
        f'[log]\ndbc = "seven.dbc"\ncloses = "Rest"\n[channels]\n{channels}\n[inputs]\n'
        'position = { unit = "mm", signal = "Axis.Place", lo = 0, hi = 900 }\n'
        'speed = { unit = "rad/s", signal = "Motor.Rate", lo = -400, hi = 400 }\n'
    )
    database = cantools.database.load_file(tmp_path / "seven.dbc")
    with can.Logger(tmp_path / "run.blf") as log:
        for k in range(40):
            rows = [
                ("Spindle", {f"Temp{n}": 20 + n + 0.1 * k for n in range(1, 5)}),
                ("Axis", {"Place": 10.0 * k}),
                ("Motor", {"Rate": -50.0}),
                ("Rest", {"Temp5": 25.0, "Temp6": 26.0, "Temp7": 3276.7}),
            ]
            for j, (name, values) in enumerate(rows):
                m = database.get_message_by_name(name)
                log.on_message_received(
                    can.Message(
                        timestamp=1e9 + 0.5 * k + 0.001 * j,
                        arbitration_id=m.frame_id,
                        is_extended_id=m.is_extended_frame,
                        data=m.encode(values),
                    )
                )
    record = read_recording(tmp_path / "run.blf", load_rig(tmp_path))
    assert len(record) == 40
    np.testing.assert_allclose(record.channels[:, 0], 21 + 0.1 * np.arange(40))
    assert record.skipped == {"n/a C7": 40}
    np.testing.assert_allclose(record.omega[1:], 50)
    np.testing.assert_allclose(np.sum(record.coverage[1:], axis=1), 80 / 800 * record.coverage.shape[1])


def test_a_message_that_came_with_29_bits_is_told_from_one_that_never_came(tmp_path: Path) -> None:
    rows = [row._replace(extended=row.id == 0x211) for row in log_fake.log(8)]
    record = read_recording(log_fake.write(tmp_path / "a.log", rows), load_rig(PAPER))
    assert record.notes[0] == (
        "Telemeter2 (0x211) never came, but 0x00000211 did: rig.dbc has it with 11 bits: no T05, T06, T07, T08"
    )
