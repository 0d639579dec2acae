"""What a DBC says is what other libraries read in it; one that does not fit the rig is named."""

from pathlib import Path

import cantools
import numpy as np
import pytest
from hypothesis import example, given, strategies as st

from drivers.decode.dbc import load_dbc
from drivers.recordings import read_recording
from estimator.errors import SetupError
from estimator.rig_folder.rig_folder import load_rig
from tests import log_fake
from tests.conftest import PAPER
from tests.drivers.decode.test_decode import words

ODD_DBC = """VERSION ""
BU_: A
BO_ 2566834709 Odd: 8 A
 SG_ Motorola : 5|13@0- (0.5,3) [0|0] "" A
 SG_ Intel : 19|11@1- (0.1,-7) [0|0] "" A
 SG_ Real : 32|32@1- (1,0) [0|0] "" A
BO_ 18 Wide: 8 A
 SG_ All : 7|64@0+ (1,0) [0|0] "" A
BO_ 19 Paged: 8 A
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" A
 SG_ First m1 : 8|16@1- (1,0) [0|0] "" A
 SG_ Second m2 : 8|16@1- (2,0) [0|0] "" A
SIG_VALTYPE_ 2566834709 Real : 1;
"""


@example(data=[bytes.fromhex("00000000010080ff"), bytes.fromhex("000000000000a07f")], odd=True)  # signalling NaNs
@given(data=st.lists(st.binary(min_size=8, max_size=8), min_size=1, max_size=20), odd=st.booleans())
def test_numpy_equals_cantools(tmp_path_factory: pytest.TempPathFactory, data: list[bytes], odd: bool) -> None:
    path = log_fake.DBC
    if odd:
        path = tmp_path_factory.getbasetemp() / "odd.dbc"
        path.write_text(ODD_DBC)
    ours, theirs = load_dbc(path), cantools.database.load_file(path)
    for message in theirs.messages:
        decoded = [
            message.decode(d, decode_choices=False, allow_excess=False)
            if len(message.signals) != 3 or message.name != "Paged" or d[0] in (1, 2)
            else {}
            for d in data
        ]
        for name, bits in ours.messages[message.name].signals.items():
            there = bits.present(words(data))
            values = bits.physical(bits.raw(words(data)))
            expected = [row.get(name) for row in decoded]
            for k, value in enumerate(expected):
                if value is None:
                    assert not there[k] or bits.selector is None
                else:
                    np.testing.assert_array_equal(values[k], float(value))


def test_dbc_is_what_others_read() -> None:
    """Also codes and time-outs, for other tools."""
    database = log_fake.database()
    assert database.get_message_by_name("Drive").cycle_time == 1000
    assert {m.frame_id for m in database.messages} == {
        *range(0x210, 0x215),
        0x220,
        0x221,
        0x230,
        0x240,
        0x241,
        0x610,
        0x611,
    }


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "Telemeter2.T07",
            "Telemeter2.T7",
            "channels.T07.signal: rig.dbc has no signal 'Telemeter2.T7'; did you mean 'Telemeter2.T07'?",
        ),
        (
            'closes = "TelemeterStatus"',
            'closes = "TelemeterStat"',
            "log.closes: rig.dbc has no message 'TelemeterStat'; did you mean 'TelemeterStatus'?",
        ),
        ("TelState = Ok", "TelState = Okay", "log.scan_state: 'Okay' is no value of TelState; did you mean 'Ok'?"),
        (
            "DspHoldState = 0",
            "DspHoldState is 0",
            "channels.displacement.valid: 'DisplacementHold.DspHoldState is 0' is no condition; "
            "expected for example 'Message.Signal = 0'",
        ),
        (
            "DisplacementHold.DspHoldSeq",
            "DisplacementDirect.DspDirectSeq",
            "channels.displacement: DisplacementDirect and DisplacementHold are two messages; a reading comes from one",
        ),
        (
            '"TelemeterStatus.TelScanCrc"',
            '"Telemeter1.T01"',
            "log.scan_crc: must be a signal of the closing message (TelemeterStatus), not of Telemeter1",
        ),
        ('dbc = "rig.dbc"', "", "log.dbc is missing: CAN frames need a DBC file"),
        ('unit = "rpm"', 'unit = "1/min"', "inputs.speed.unit: '1/min' is no unit of it; use rpm or rad/s"),
        (', signal = "Telemeter2.T07"', "", "channels.T07: 'signal' is missing: which signal of rig.dbc is it?"),
    ],
)
def test_a_rig_file_that_does_not_fit(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = (PAPER / "rig.toml").read_text()
    assert old in text
    (tmp_path / "rig.toml").write_text(text.replace(old, new))
    path = log_fake.write(tmp_path / "a.log", log_fake.log(2))
    with pytest.raises(SetupError) as error:
        read_recording(path, load_rig(tmp_path))
    assert str(error.value) == f"{tmp_path / 'rig.toml'}: {message}"


def test_a_missing_or_broken_dbc(tmp_path: Path) -> None:
    text = (PAPER / "rig.toml").read_text()
    (tmp_path / "rig.toml").write_text(text.replace('"rig.dbc"', '"mine.dbc"'))
    path = log_fake.write(tmp_path / "a.log", log_fake.log(2))
    with pytest.raises(SetupError, match=r"log\.dbc: no file 'mine\.dbc' in .* or .*drivers"):
        read_recording(path, load_rig(tmp_path))
    (tmp_path / "mine.dbc").write_text("BO_ what")
    with pytest.raises(SetupError, match=r"mine\.dbc: cannot be read as a DBC: "):
        read_recording(path, load_rig(tmp_path))


BROKEN = {
    "overlap": ' SG_ Flags : 0|8@1+ (1,0) [0|255] "" X\n SG_ Low : 3|1@1+ (1,0) [0|1] "" X\n',
    "beyond its end": ' SG_ Far : 60|16@1+ (1,0) [0|0] "" X\n',
    "beyond its end, Motorola": ' SG_ Far : 60|16@0+ (1,0) [0|0] "" X\n',
}


@pytest.mark.parametrize("kind", BROKEN)
def test_of_a_plants_dbc_only_what_the_rig_names_is_judged(tmp_path: Path, kind: str) -> None:
    plant = (Path(log_fake.DBC).read_text()) + f"\nBO_ 800 Gearbox: 8 X\n{BROKEN[kind]}"
    (tmp_path / "plant.dbc").write_text(plant)
    text = (PAPER / "rig.toml").read_text().replace('"rig.dbc"', '"plant.dbc"')
    (tmp_path / "rig.toml").write_text(text)
    path = log_fake.write(tmp_path / "a.log", log_fake.log(4))
    record = read_recording(path, load_rig(tmp_path))
    assert record.fingerprint == read_recording(path, load_rig(PAPER)).fingerprint
    assert any(note.startswith("plant.dbc: message 'Gearbox' is not read: ") for note in record.notes)
    (tmp_path / "rig.toml").write_text(text.replace('"Drive.DrvSpeed"', '"Gearbox.Low"'))
    with pytest.raises(SetupError, match=r"inputs\.speed.*: message 'Gearbox' of plant\.dbc is broken: The signal"):
        read_recording(path, load_rig(tmp_path))
