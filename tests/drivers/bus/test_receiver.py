"""The receiver and everything that a bus can do to it: it never ends, and says how long it was without frames."""

import threading
import time
from collections.abc import Callable
from types import SimpleNamespace

import can
import pytest

from drivers.bus import receiver as receiving
from drivers.bus.bus import BusAddress, Listener, bus_options, told
from drivers.bus.receiver import Receiver
from drivers.bus.rig_time import RigTime
from drivers.received import Notice, Received
from estimator.errors import InputError, SetupError
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

        receiver = Receiver(opens, RigTime(), [recorded.append])
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


def test_all_who_hear_are_told_before_anybody_takes_a_frame(impatient):
    """A publisher knows its own echo for some seconds: it cannot wait until the estimate has time for it."""
    told: list[list[Received]] = [[], []]
    receiver = Receiver(lambda: Listener(Script(message(1), message(2))), RigTime(), [each.append for each in told])
    receiver.start()
    until(lambda: len(told[1]) == 2)
    assert told[0] == told[1]
    assert receiver.waiting
    receiver.stop()
    while receiver.take(0.0):
        pass
    assert not receiver.waiting


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


def test_what_the_estimate_is_too_slow_for_is_counted(impatient, monkeypatch):
    monkeypatch.setattr(receiving, "MOST_WAITING", 10)
    recorded: list[Received] = []
    receiver = Receiver(lambda: Listener(Script(*(message(k) for k in range(50)))), RigTime(), [recorded.append])
    receiver.start()
    until(lambda: len(recorded) == 50)
    receiver.stop()
    assert len(recorded) == 50
    waiting = receiver.take(0)
    assert len(waiting) == 10
    assert receiver.dropped == 41  # the first place was taken by the notice


def test_how_old_a_frame_is_counts_the_buffers_before_us(monkeypatch):
    """The reader is held up for 20 s after the first frame: the second has waited for it, in no queue of ours."""
    received_s = [0.0, 1.0, 22.0, 22.1]
    monkeypatch.setattr(receiving, "AT_ONCE", 1)
    monkeypatch.setattr(receiving, "time", SimpleNamespace(monotonic=lambda: received_s[3 - len(bus.items)]))
    bus = Script(message(1), message(2), message(3))
    receiver = Receiver(lambda: Listener(bus), RigTime(), [])
    receiver.start()
    until(lambda: receiver.frames == 3)
    assert isinstance(receiver.take(0)[0], Notice)
    ages = [receiver.age_s for _ in range(3) if receiver.take(0)]
    assert ages == pytest.approx([21.1, 20.1, 19.1], abs=0.05)
    receiver.stop()


def test_what_the_kernel_had_no_room_for_is_counted_and_told(impatient):
    bus, lost = Script(*(message(k) for k in range(5))), [0, 0, 7, 7, 9]
    receiver = Receiver(lambda: Listener(bus, lambda: lost[4 - len(bus.items)]), RigTime(), [])
    receiver.start()
    until(lambda: receiver.missed == 9)
    receiver.stop()
    told = [each.text for each in receiver.take(0) if isinstance(each, Notice)]
    assert told == ["listening on can0", "7 frames lost so far: this machine reads too slowly"]


def test_an_interface_that_does_not_exist_ends_it():
    receiver = Receiver(BusAddress("nonsense", "can0").listen, RigTime(), [])
    receiver.start()
    until(lambda: receiver.failure)
    receiver.stop()
    assert isinstance(receiver.failure, SetupError)
    assert "nonsense" in str(receiver.failure)


@pytest.mark.parametrize("why", ["OSError: [Errno 19] No such device", "it does not answer"])
def test_an_interface_that_never_opens_is_an_error(impatient, monkeypatch, why):
    monkeypatch.setattr(receiving, "OPEN_S", 0.1)
    ended = threading.Event()

    def opens() -> Listener:
        if why.startswith("it"):
            ended.wait()
        raise OSError(19, "No such device")

    receiver = Receiver(opens, RigTime(), [], "can7")
    receiver.start()
    until(lambda: receiver.take(0.01) is None or receiver.failure)
    ended.set()
    receiver.stop()
    assert isinstance(receiver.failure, InputError)
    assert str(receiver.failure) == f"can7: could not be opened for 0.1 s: {why}"


def test_a_bus_that_has_been_open_is_waited_for(impatient, monkeypatch):
    left: list = [OSError("not yet"), Listener(Script(message(1), OSError("gone")))]

    def opens() -> Listener:
        found = left.pop(0) if left else OSError("gone")
        if isinstance(found, OSError):
            raise found
        return found

    receiver = Receiver(opens, RigTime(), [])
    receiver.start()
    until(lambda: receiver.frames and receiver.state == "lost")
    monkeypatch.setattr(receiving, "OPEN_S", 0.0)
    told = [each.text.split(" ")[:2] for each in receiver.take(0.01) if isinstance(each, Notice)]
    receiver.stop()
    assert receiver.failure is None
    assert told == [["bus", "not"], ["listening", "on"], ["frames", "again"], ["bus", "lost:"]]


def test_a_listener_has_no_way_to_transmit():
    with can.Bus(interface="virtual", channel="quiet") as bus:
        assert not hasattr(Listener(bus), "send")
        assert not hasattr(Listener(bus), "send_periodic")


def test_a_traceback_in_what_python_can_says_is_left_out():
    error = can.CanError("Failed to receive: gone  Traceback (most recent call last):\n  File ...\nOSError: gone\n")
    assert told(error) == "CanError: Failed to receive: gone"


def test_options_of_the_interface():
    words = ("host=127.0.0.1", "port=28610", "listen_only=False", "name=a=b")
    assert bus_options(words) == {"host": "127.0.0.1", "port": 28610, "listen_only": False, "name": "a=b"}
    with pytest.raises(SetupError, match="--bus-kwargs host: write NAME=VALUE"):
        bus_options(("host",))
