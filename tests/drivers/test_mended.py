"""Broken parts of a plant's DBC, in messages that the rig does not name, and in one that it does."""

import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.mended import read_dbc
from drivers.recordings import read_recording
from estimator.errors import SetupError
from estimator.rig import Rig
from estimator.rig_folder.rig_folder import load_rig
from tests import log_fake
from tests.conftest import ROOT

ROWS = log_fake.log(6)
PLAIN = ' SG_ X : 0|8@1+ (1,0) [0|1] "" Ballscrew'


@pytest.fixture
def rig(tmp_path: Path) -> Rig:
    shutil.copy(ROOT / "recordings/rig.toml", tmp_path)
    rig = load_rig(tmp_path)
    return replace(rig, log=replace(rig.log, dbc="plant.dbc"))


def plant(rig: Rig, message: str = "", end: str = "", encoding: str = "utf-8") -> None:
    text = (ROOT / "drivers/rig.dbc").read_text().replace("BO_ 528 ", f"{message}\n\nBO_ 528 ", 1) + end
    (rig.folder / "plant.dbc").write_text(text, encoding=encoding)


@pytest.mark.parametrize(
    ("message", "end", "said"),
    [
        (f"BO_ 300 Gear-box: 8 Telemeter\n{PLAIN}", "", "'Gear-box' is not read: "),
        (f"BO_ 300 Getriebeöl: 8 Telemeter\n{PLAIN}", "", "'Getriebeöl' is not read: "),
        ('BO_ 300 Gearbox: 8 Telemeter\n SG_ X : 0|0@1+ (1,0) [0|1] "" Ballscrew', "", "length 0 is not greater"),
        ('BO_ 300 Gearbox: 8 Telemeter\n SG_ X : 0|8@1+ (0,5,0) [0|1] "" Ballscrew', "", "'Gearbox' is not read"),
        (f"BO_ 99999 Gearbox: 8 Telemeter\n{PLAIN}", 'VAL_ 99999 X 0 "a" ;\n', "more than 11 bits"),
        ("", '\nVAL_ 9999 Nope 0 "x" ;\n', "unused VAL_ entries"),
        ("", '\nCM_ BO_ 560 "a "quoted" word";\n', "Invalid syntax"),
        ('BO_ 300 Gearbox: 8 Telemeter\n SG_ X : 0|8@1+ (0,0) [0|1] "" Ballscrew', "", ""),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "cp1252"])
def test_the_rest_is_read_and_what_is_not_is_said(tmp_path: Path, rig: Rig, message, end, said, encoding) -> None:
    path = log_fake.write(tmp_path / "a.log", ROWS)
    plain = read_recording(path, load_rig(tmp_path))
    plant(rig, message, end, encoding)
    record = read_recording(path, rig)
    np.testing.assert_array_equal(record.channels, plain.channels)
    assert any(said in note for note in record.notes) or not said


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (
            lambda text: text.replace("BO_ 560 Drive:", "BO_ 300 Drive: 8 Telemeter\n\nBO_ 560 Drive:"),
            "two messages have",
        ),
        (lambda text: text.replace("SG_ DrvCurrent : ", "SG_ Drv-Current : "), "Invalid syntax"),
    ],
)
def test_a_message_that_the_rig_names_is_refused(tmp_path: Path, rig: Rig, change, why: str) -> None:
    (tmp_path / "plant.dbc").write_text(change((ROOT / "drivers/rig.dbc").read_text()))
    with pytest.raises(SetupError, match=rf"message 'Drive' of plant.dbc is broken: .*{why}"):
        read_recording(log_fake.write(tmp_path / "a.log", ROWS), rig)


def test_what_is_no_dbc_is_refused(tmp_path: Path, rig: Rig) -> None:
    (tmp_path / "plant.dbc").write_text("MZ\0\1 not at all\n" * 50)
    with pytest.raises(SetupError, match="cannot be read as a DBC"):
        read_recording(log_fake.write(tmp_path / "a.log", ROWS), rig)


def test_a_dbc_in_utf_16(tmp_path: Path, rig: Rig) -> None:
    (tmp_path / "plant.dbc").write_text((ROOT / "drivers/rig.dbc").read_text(), encoding="utf-16")
    assert not any("plant.dbc" in note for note in read_recording(log_fake.write(tmp_path / "a.log", ROWS), rig).notes)


def test_what_is_not_a_dbc_is_told_by_how_it_begins(tmp_path: Path) -> None:
    path = tmp_path / "plant.dbc"
    path.write_text("(1.0) can0 210#00\n" * 9)
    with pytest.raises(ValueError, match=r"no line begins with BO_, where .*; it begins with '\(1.0\) can0 210#00'"):
        read_dbc(path)
    with pytest.raises(ValueError, match=r"no file of messages by its suffix; expected .dbc, .arxml"):
        read_dbc(path.rename(tmp_path / "plant.log"))


def test_units_of_a_dbc_that_are_not_those_of_the_rig_are_said_once(tmp_path: Path, rig: Rig) -> None:
    text = re.sub(r'(SG_ T\d\d : .*)"degC"', r'\1"degF"', (ROOT / "drivers/rig.dbc").read_text())
    (tmp_path / "plant.dbc").write_text(text)
    path = log_fake.write(tmp_path / "a.log", ROWS)
    said = "T01, T02, T03 and 12 more: in degF by plant.dbc, in degC by rig.toml: convert there, scale and offset"
    assert [note for note in read_recording(path, rig).notes if "plant.dbc" in note] == [said]
    converts = {name: replace(one, scale=5 / 9, offset=-160 / 9) for name, one in rig.channels.items()}
    assert not any("plant.dbc" in note for note in read_recording(path, replace(rig, channels=converts)).notes)
