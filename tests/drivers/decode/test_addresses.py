"""J1939: the same parameter group from another address."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from drivers.decode.addresses import group_of
from drivers.frames import Tally
from drivers.logs.every_frame import every_frame
from drivers.recordings import read_recording
from drivers.ticker import Ticker
from estimator.errors import InputError
from estimator.rig import Rig
from estimator.rig_folder.rig_folder import load_rig
from tests import log_fake
from tests.conftest import ROOT

ROWS = log_fake.log(10)


@pytest.fixture
def rig(tmp_path: Path) -> Rig:
    """The paper's rig whose drive has a 29-bit id in the DBC: group FF30 from address FE."""
    text = (ROOT / "drivers/rig.dbc").read_text()
    for kind in ("BO_", "SG_", "VAL_"):
        text = text.replace(f"{kind} 560 ", f"{kind} {0x80000000 | 0x18FF30FE} ")
    (tmp_path / "plant.dbc").write_text(text)
    toml = (ROOT / "recordings/rig.toml").read_text()
    (tmp_path / "rig.toml").write_text(toml.replace('"rig.dbc"', '"plant.dbc"'))
    shutil.copy(ROOT / "recordings/model.toml", tmp_path)
    return load_rig(tmp_path)


def written(path: Path, *ids: int) -> Path:
    """The log with the drive's frames under these ids, one after the other."""
    rows = [row._replace(id=ids[k % len(ids)], extended=True) if row.id == 0x230 else row for k, row in enumerate(ROWS)]
    return log_fake.write(path, rows)


@pytest.mark.parametrize("can_id", [0x18FF3021, 0x0CFF3000])
def test_another_address_or_priority_is_read_and_said(tmp_path: Path, rig: Rig, can_id: int) -> None:
    record = read_recording(written(tmp_path / "a.log", can_id), rig)
    same = read_recording(written(tmp_path / "b.log", 0x18FF30FE), rig)
    np.testing.assert_array_equal(record.omega, same.omega)
    assert f"Drive is read from 0x{can_id:08X}: plant.dbc has it as 0x18FF30FE" in record.notes[0]
    assert same.notes == ()


def test_two_senders_are_refused(tmp_path: Path, rig: Rig) -> None:
    with pytest.raises(InputError, match="from the source addresses of 0x18FF3021 and 0x18FF3022: write"):
        read_recording(written(tmp_path / "a.log", 0x18FF3021, 0x18FF3022), rig)


def test_another_group_is_none_of_it_and_what_never_came_is_said_first(tmp_path: Path, rig: Rig) -> None:
    record = read_recording(written(tmp_path / "a.log", 0x18FF3121), rig)
    assert record.notes[0] == "Drive (0x18FF30FE) never came: no position, speed, current"


def test_the_receiver_is_no_part_of_a_group_that_has_one() -> None:
    ids = np.array([0x18EA21FE, 0x18EAFF03, 0x18EB21FE, 0x18FF3021])
    assert group_of(ids).tolist() == [0x00EA0000, 0x00EA0000, 0x00EB0000, 0x00FF3000]


@pytest.mark.parametrize("ids", [(0x18FF3021,), (0x18FF30FE,)])
def test_live_reads_the_same(tmp_path: Path, rig: Rig, ids: tuple[int, ...]) -> None:
    path = written(tmp_path / "a.log", *ids)
    ticker = Ticker(rig)
    frames = list(every_frame(path, Tally()))
    lived = [sample for f in frames for sample in ticker.feed(f.time_s, f.id, f.extended, f.data)]
    same = read_recording(path, rig)
    np.testing.assert_array_equal([sample.omega for sample in lived], same.omega[: len(lived)])
    assert list(ticker.tally.notes) == [note for note in same.notes if "read from" in note]


def test_live_the_id_of_the_dbc_counts_once_it_comes_and_a_second_sender_never(rig: Rig) -> None:
    addresses = Ticker(rig).addresses
    own, first, second = 0x18FF30FE, 0x18FF3021, 0x18FF3022
    assert [addresses.id_of(one, True) for one in (first, second, first)] == [own, second, own]
    assert [addresses.id_of(one, True) for one in (own, first, second)] == [own, first, second]
    assert addresses.id_of(own, False) == own


def test_a_message_that_is_never_as_long_as_the_dbc_says_is_said_first(tmp_path: Path, rig: Rig) -> None:
    rows = [row._replace(data=row.data[:5]) if row.id == 0x240 else row for row in ROWS]
    record = read_recording(log_fake.write(tmp_path / "a.log", rows), load_rig(ROOT / "recordings"))
    assert record.notes[0].startswith("Environment1 (0x240) has 5 bytes, 8 in rig.dbc: no ambient, base")
