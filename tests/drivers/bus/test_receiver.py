"""The receiver and everything that a bus can do to it: it never ends, and says how long it was without frames."""

from __future__ import annotations

import time
from collections.abc import Callable

import can
import pytest

from drivers.bus import receiver as receiving
from drivers.bus.bus import BusAddress, Listener, bus_options
from drivers.bus.receiver import Notice, Receiver
from drivers.bus.rig_time import RigTime
from drivers.received import Received
from estimator.errors import SetupError
from tests.processes import until


class Script:
    """A bus that brings messages, None for silence, and raises exceptions, one after the other; then silence."""

    def __init__(self, *items: object) -> None:
        self.items, self.closed = list(items), 0

    def recv(self, timeout: float) -> can.Message | None:
        item = self.items.pop(0) if self.items else None
        if isinstance(item, Exception):
            raise item
        if item is None and not self.items:
            time.sleep(timeout)
        return item

    def shutdown(self) -> None:
        self.closed += 1


def message(number: int = 1, **more: object) -> can.Message:
    return can.Message(timestamp=1000.0 + number, arbitration_id=0x214, is_extended_id=False, data=[number], **more)


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(receiving, "BACK_OFF_S", (0.01, 0.02))
    monkeypatch.setattr(receiving, "WAIT_S", 0.05)


@pytest.fixture
def received(impatient) -> Callable[..., tuple[list[Received], list[Notice], Receiver]]:
    """received(*buses, frames=n): what comes of these buses, opened one after the other, until there are n frames."""

    def of(*buses: object, frames: int) -> tuple[list[Received], list[Notice], Receiver]:
        left, recorded = list(buses), []

        def opens() -> Listener:
            bus = left.pop(0) if left else Script()
            if isinstance(bus, Exception):
                raise bus
            return Listener(bus)

        receiver = Receiver(opens, RigTime(), recorded.append)
        receiver.start()
        found = []

        def all_there() -> bool:
            found.extend(receiver.take(0.02))
            return sum(isinstance(each, Received) for each in found) >= frames

        until(all_there)
        receiver.stop()
        found += receiver.take(0)
        taken = [each for each in found if isinstance(each, Received)]
        assert recorded == taken or any(each.kind == "error" for each in recorded)
        listening, *notices = (each for each in found if isinstance(each, Notice))
        assert listening == Notice("listening on can0", "INFO")
        return taken, notices, receiver

    return of


def test_frames_come_in_order_and_the_bus_is_closed(received):
    bus = Script(message(1), None, message(2), message(3))
    frames, notices, receiver = received(bus, frames=3)
    assert [f.data for f in frames] == [b"\1", b"\2", b"\3"]
    assert [f.time_s for f in frames] == [1001.0, 1002.0, 1003.0]
    assert receiver.frames == 3
    assert not notices
    assert bus.closed == 1


@pytest.mark.parametrize(
    "failure", [can.CanOperationError("unplugged"), OSError("gone"), ValueError("junk"), KeyError("driver")]
)
def test_an_adaptor_that_goes_is_opened_again(received, failure):
    first = Script(message(1), failure)
    frames, notices, _ = received(first, OSError("not there yet"), Script(message(2)), frames=2)
    assert len(frames) == 2
    assert first.closed == 1
    lost, back = notices
    assert lost.text.startswith(f"bus lost: {type(failure).__name__}: ")
    assert back.level == "INFO"
    assert back.text.startswith("frames again after ")


def test_a_silent_bus_is_opened_anew(received, monkeypatch):
    monkeypatch.setattr(receiving, "SILENT_S", (0.5, 0.6))
    silent = Script(message(1))
    frames, notices, _ = received(silent, Script(message(2)), frames=2)
    assert len(frames) == 2
    assert silent.closed == 1
    assert [n.text.split(" ")[0] for n in notices] == ["no", "frames"]


def test_error_frames_are_counted_and_bus_off_is_told(received):
    error = message(1, is_error_frame=True)
    error.arbitration_id = 0x04
    off = message(2, is_error_frame=True)
    off.arbitration_id = 0x40
    frames, notices, receiver = received(Script(error, error, off, message(3)), frames=1)
    assert len(frames) == 1
    assert receiver.errors == 3
    assert [n.text for n in notices] == [
        "error frame, 1 so far (class 0x4, 01)", "bus off: the controller has left the bus (class 0x40, 02)",
    ]  # fmt: skip


def test_what_the_estimate_is_too_slow_for_is_counted(received, monkeypatch):
    monkeypatch.setattr(receiving, "MOST_WAITING", 10)
    recorded: list[Received] = []
    receiver = Receiver(lambda: Listener(Script(*(message(k) for k in range(50)))), RigTime(), recorded.append)
    receiver.start()
    until(lambda: len(recorded) == 50)
    receiver.stop()
    assert len(recorded) == 50
    waiting = receiver.take(0)
    assert len(waiting) == 10
    assert receiver.dropped == 41  # the first place was taken by the notice


def test_an_interface_that_does_not_exist_ends_it():
    receiver = Receiver(BusAddress("nonsense", "can0").listen, RigTime(), print)
    receiver.start()
    until(lambda: receiver.failure)
    receiver.stop()
    assert isinstance(receiver.failure, SetupError)
    assert "nonsense" in str(receiver.failure)


def test_a_listener_has_no_way_to_transmit():
    with can.Bus(interface="virtual", channel="quiet") as bus:
        assert not hasattr(Listener(bus), "send")
        assert not hasattr(Listener(bus), "send_periodic")


def test_options_of_the_interface():
    words = ("host=127.0.0.1", "port=28610", "listen_only=False", "name=a=b")
    assert bus_options(words) == {"host": "127.0.0.1", "port": 28610, "listen_only": False, "name": "a=b"}
    with pytest.raises(SetupError, match="--bus-kwargs host: write NAME=VALUE"):
        bus_options(("host",))
