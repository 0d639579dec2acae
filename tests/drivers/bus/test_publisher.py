"""What we send: decoded with cantools it says what the estimate says, and nothing else is ever sent."""

import dataclasses
from pathlib import Path

import can
import cantools
import numpy as np
import pytest

from ballscrew.monitor.monitor import Monitor
from drivers.bus import publisher as publishing
from drivers.bus.publisher import Publisher
from drivers.decode.dbc import find_dbc
from drivers.received import Received
from estimator.alarms.trust import Trust
from estimator.errors import SetupError
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.step import Mode, Step
from tests.conftest import PAPER
from tests.live_fake import rig_frames
from tests.log_fake import crc

GOOD = Trust((), False, False, False)
BAD = Trust(("no news of the drive",), True, True, True)


@pytest.fixture(scope="module")
def rig():
    return load_rig(PAPER)


@pytest.fixture(scope="module")
def dbc(rig):
    return cantools.database.load_file(Path(publishing.__file__).parents[1] / "rig.dbc")


@pytest.fixture(scope="module")
def step(rig) -> Step:
    monitor = Monitor(load_model(PAPER / "model.toml"), rig)
    moments = [moment for frame in rig_frames(40.0) for moment in monitor.feed(frame)]
    return dataclasses.replace(moments[-1].step, mode=Mode.UPDATE)


class Bus:
    def __init__(self, fails: bool = False) -> None:
        self.sent, self.fails, self.closed, self.waiting = [], fails, False, 0

    def send(self, message: can.Message, timeout: float | None = None) -> None:
        if self.fails:
            raise can.CanOperationError("no acknowledge")
        self.sent.append(message)

    def recv(self, timeout: float) -> can.Message | None:
        self.waiting -= 1
        return can.Message() if self.waiting >= 0 else None

    def shutdown(self) -> None:
        self.closed = True


def decoded(dbc, frames):
    return [dbc.decode_message(f.arbitration_id, f.data, decode_choices=False) for f in frames]


def test_the_frames_say_what_the_estimate_says(rig, dbc, step):
    publisher = Publisher(rig, Bus)
    frames = publisher.frames(step, GOOD, 123.4567)
    assert [(f.arbitration_id, f.is_extended_id, f.dlc) for f in frames] == [(0x610, False, 8), (0x611, False, 8)]
    estimate, compensation = decoded(dbc, frames)
    assert estimate["EstElongation"] == pytest.approx(step.elongation_um, abs=5.1e-4)
    assert estimate["EstSigma"] == pytest.approx(step.sigma_um, abs=5.1e-4)
    assert (estimate["EstMode"], estimate["EstChannels"]) == (2, 15)
    assert (estimate["EstDisplacementStale"], estimate["EstTelemeterStale"], estimate["EstDiverged"]) == (0, 0, 0)
    assert compensation["CmpError"] == pytest.approx(step.error_at_table_um, abs=5.1e-4)
    assert compensation["CmpPosition"] == pytest.approx(123.4567, abs=5.1e-5)
    assert compensation["CmpValid"] == 1


def test_counters_run_and_checksums_are_right(rig, step):
    """Checksums against the rig's own code, which shares nothing with ours."""
    publisher = Publisher(rig, Bus)
    frames = [f for _ in range(17) for f in publisher.frames(step, GOOD, 0.0)]
    assert [f.data[1] & 15 for f in frames[::2]] == [*range(15), 0, 1]
    assert [f.data[1] & 15 for f in frames[1::2]] == [*range(15), 0, 1]
    for frame in frames:
        key = bytes([frame.arbitration_id & 255, frame.arbitration_id >> 8])
        assert frame.data[0] == crc(key + bytes(frame.data[1:]), 0x1D, 8, 0xFF, 0xFF)


def test_what_is_not_to_be_relied_on_is_invalid(rig, dbc, step):
    estimate, compensation = decoded(dbc, Publisher(rig, Bus).frames(step, BAD, 1.0))
    assert estimate["EstMode"] == 14
    assert (estimate["EstDisplacementStale"], estimate["EstTelemeterStale"], estimate["EstDiverged"]) == (1, 1, 1)
    assert compensation["CmpValid"] == 0


def test_before_the_start_and_without_a_position_nothing_is_made_up(rig, dbc, step):
    waiting = dataclasses.replace(step, mode=Mode.INIT, elongation_um=np.nan, sigma_um=np.nan, error_at_table_um=np.nan)
    estimate, compensation = decoded(dbc, Publisher(rig, Bus).frames(waiting, Trust(), np.nan))
    assert (estimate["EstMode"], estimate["EstElongation"]) == (0, 0)
    assert estimate["EstSigma"] == pytest.approx(65.535)
    assert (compensation["CmpValid"], compensation["CmpPosition"]) == (0, 0)
    assert decoded(dbc, Publisher(rig, Bus).frames(step, GOOD, np.nan))[1]["CmpValid"] == 0


def test_numbers_beyond_their_bits_stop_at_the_end(rig, dbc, step):
    wide = dataclasses.replace(step, elongation_um=1e5, sigma_um=1e3, error_at_table_um=-1e5)
    estimate, compensation = decoded(dbc, Publisher(rig, Bus).frames(wide, GOOD, 1e6))
    assert estimate["EstElongation"] == pytest.approx(8388.607)
    assert estimate["EstSigma"] == pytest.approx(65.534)
    assert compensation["CmpError"] == pytest.approx(-8388.608)


def turns(publisher: Publisher) -> None:
    """All that waits to be sent, as the publisher's own thread does it."""
    while not publisher._jobs.empty():
        publisher.turn(0)


def test_a_change_of_validity_goes_out_at_once_and_the_same_not_faster_than_the_rate(rig, step, monkeypatch):
    monkeypatch.setattr(publishing, "SPACING_S", 60.0)
    bus = Bus()
    publisher = Publisher(rig, lambda: bus)
    for trust in (GOOD, GOOD, GOOD, BAD, BAD):
        publisher.send(step, trust, 0.0)
    turns(publisher)
    assert [m.data[1] >> 4 for m in bus.sent if m.arbitration_id == 0x610] == [2, 14]


def test_another_sender_of_our_ids_ends_it_and_an_echo_does_not(rig, step, monkeypatch):
    bus = Bus()
    publisher = Publisher(rig, lambda: bus)
    monkeypatch.setattr(publishing, "SPACING_S", 0.0)
    for _ in range(200):
        publisher.send(step, GOOD, 0.0)
        turns(publisher)
    for own in bus.sent:
        publisher.heard(Received(1.0, own.arbitration_id, False, bytes(own.data)))
    assert not publisher.trouble
    publisher.heard(Received(1.1, 0x610, False, bytes(8)))
    assert publisher.trouble == "not publishing any more: 0x610 comes from another sender"
    publisher.send(step, GOOD, 0.0)
    turns(publisher)
    assert len(bus.sent) == 400


def test_a_bus_that_fails_is_told_and_tried_again(rig, step, monkeypatch):
    monkeypatch.setattr(publishing, "SPACING_S", 0.0)
    buses = [Bus(fails=True), Bus()]
    publisher = Publisher(rig, lambda: buses.pop(0))
    for _ in range(2):
        publisher.send(step, GOOD, 0.0)
        turns(publisher)
        assert publisher.trouble == "not publishing: CanOperationError: no acknowledge"
    assert len(buses) == 1
    monkeypatch.setattr(publisher, "_retry", 0.0)
    publisher.send(step, GOOD, 0.0)
    turns(publisher)
    assert (publisher.sent, publisher.trouble) == (2, "")


def test_what_is_old_is_not_sent_and_what_comes_in_is_read(rig, step, monkeypatch):
    bus = Bus()
    publisher = Publisher(rig, lambda: bus)
    publisher.send(step, GOOD, 0.0)
    turns(publisher)
    monkeypatch.setattr(publishing, "STALE_S", -1.0)
    publisher.send(step, BAD, 0.0)
    bus.waiting = 300
    turns(publisher)
    assert len(bus.sent) == 2
    assert bus.waiting < 0


def test_the_last_word_is_that_it_is_not_valid(rig, dbc, step):
    bus = Bus()
    publisher = Publisher(rig, lambda: bus)
    publisher.start()
    publisher.send(step, GOOD, 1.0)
    publisher.close()
    estimate, compensation = decoded(dbc, bus.sent[-2:])
    assert (estimate["EstMode"], compensation["CmpValid"]) == (14, 0)
    assert decoded(dbc, bus.sent[:1])[0]["EstMode"] == 2
    assert bus.closed


def test_a_dbc_without_our_messages_cannot_publish(rig, tmp_path):
    (tmp_path / "other.dbc").write_text('VERSION ""\n\nBU_: A\n\nBO_ 1 Some: 8 A\n SG_ S : 0|8@1+ (1,0) [0|255] "" A\n')
    other = dataclasses.replace(rig, folder=tmp_path, log=dataclasses.replace(rig.log, dbc="other.dbc"))
    with pytest.raises(SetupError, match=r"--publish: .*other.dbc has no message 'Estimate'"):
        Publisher(other, Bus)


def test_a_message_of_others_may_be_broken(rig, tmp_path):
    text = find_dbc("rig.dbc", tmp_path).read_text()
    (tmp_path / "plant.dbc").write_text(text + '\nBO_ 800 Gearbox: 8 X\n SG_ Far : 60|16@1+ (1,0) [0|0] "" X\n')
    plant = dataclasses.replace(rig, folder=tmp_path, log=dataclasses.replace(rig.log, dbc="plant.dbc"))
    assert not Publisher(plant, Bus).trouble
