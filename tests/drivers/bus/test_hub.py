"""The hub: real sockets, python-can's own client, and clients that are slow, wrong or gone."""

import asyncio
import re
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from unittest import mock

import can
import pytest

from drivers.bus.hub import Hub, Stamp, _Client
from estimator.errors import SetupError
from tests.hub_fake import hub_running
from tests.processes import PATIENCE_S, ended, until


class Raw:
    """A client by hand."""

    def __init__(self, port: int, room: int = 0) -> None:
        self.socket = socket.socket()
        if room:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, room)
        self.socket.settimeout(PATIENCE_S)
        self.socket.connect(("127.0.0.1", port))
        assert self.hears() == "< hi >"

    def says(self, text: str) -> None:
        self.socket.sendall(text.encode())

    def hears(self) -> str:
        return self.socket.recv(65536).decode("ascii")

    def asks(self, text: str) -> str:
        self.says(text)
        return self.hears()

    def joins(self, channel: str = "can0") -> "Raw":
        assert self.asks(f"< open {channel} >") == "< ok >"
        assert self.asks("< rawmode >") == "< ok >"
        return self


@contextmanager
def raw(port: int, room: int = 0) -> Iterator[Raw]:
    client = Raw(port, room)
    with client.socket:
        yield client


def message(k: int, **more: object) -> can.Message:
    return can.Message(arbitration_id=0x210 + k % 8, is_extended_id=False, data=k.to_bytes(4, "big"), **more)


def same(heard: can.Message | None, sent: can.Message) -> bool:
    return heard is not None and heard.equals(sent, timestamp_delta=None, check_channel=False, check_direction=False)


def test_every_frame_goes_to_all_others_on_its_channel(bus, hub) -> None:
    sender, one, two, elsewhere = bus(), bus(), bus(), bus("can1")
    sent = [
        can.Message(arbitration_id=0x7FF, is_extended_id=False, data=[0, 1, 0x0A, 0xFF]),
        can.Message(arbitration_id=0x1FFFFFFF, is_extended_id=True, data=range(8)),
        can.Message(arbitration_id=0x12, is_extended_id=True, data=[0]),
        can.Message(arbitration_id=0, is_extended_id=False, data=[]),
        *map(message, range(2000)),
    ]
    begun = time.time()
    for one_message in sent:
        sender.send(one_message)
    for listener in (one, two):
        heard = [listener.recv(PATIENCE_S) for _ in sent]
        assert all(map(same, heard, sent))
        stamps = [one_message.timestamp for one_message in heard]
        assert stamps == sorted(stamps)
        assert begun - 0.1 < stamps[0]
        assert stamps[-1] < time.time() + 0.1
    one.send(message(1))
    assert same(sender.recv(PATIENCE_S), message(1))  # and nothing of its own before it
    assert elsewhere.recv(0) is None
    assert hub.frames == len(sent) + 1


def test_a_frame_is_never_glued_to_the_reply_that_python_can_waits_for(port) -> None:
    """Many frames are there before the client takes its reply, in one recv."""
    with raw(port) as sender, raw(port) as client:
        sender.joins()
        client.asks("< open can0 >")
        client.says("< rawmode >")
        for _ in range(100):
            assert sender.asks("< echo >") == "< echo >"  # by then the hub has had time for the other
            sender.says("< send 123 1 7 >")
        assert sender.asks("< echo >") == "< echo >"
        assert client.hears() == "< ok >"
        assert re.fullmatch(r"(< frame 123 \d+\.\d{6} 07 >)+", client.hears())


def test_clients_connect_to_a_busy_bus(bus) -> None:
    sender = bus()
    for k in range(30):
        for j in range(20):
            sender.send(message(j))
        listener = bus()
        sender.send(message(k))
        heard = listener.recv(PATIENCE_S)
        while not same(heard, message(k)):
            heard = listener.recv(PATIENCE_S)


@pytest.mark.parametrize(
    "text",
    [
        "< send 123 2 11 >",
        "< send 123 9 1 2 3 4 5 6 7 8 9 >",
        "< send 800 0 >",
        "< send 12345 0 >",
        "< send 20000000 0 >",
        "< send 123 1 111 >",
        "< send 123 1 xx >",
        "< send -12 1 11 >",
        "< send >",
        "< open >",
        "< open can0 can1 >",
        "< dance >",
        "< >",
        ">",
        "hello>",
        "\x00\xff<<< send 1 >",
        "x" * 5000,
    ],
)
def test_a_wrong_command_gets_an_error_and_harms_nobody(port, text) -> None:
    with raw(port) as client, raw(port) as other:
        other.joins()
        client.joins()
        assert re.fullmatch(r"< error 000 \d+\.\d{6} [^<>]+ >", client.asks(text))
        client.says("< send 123 1 7 >")
        assert re.fullmatch(r"< frame 123 \d+\.\d{6} 07 >", other.hears())


def test_commands_in_pieces_and_in_one_piece(port) -> None:
    with raw(port) as client, raw(port) as other:
        other.joins()
        for letter in "< open can0 ":
            client.says(letter)
            time.sleep(0.001)
        assert client.asks(">") == "< ok >"
        client.says("< statistics 100 >\n< send 1 0 >\n<send 00000001 2 A bc>< close >< send 5 0 >")
        heard = client.hears()
        while heard.count(">") < 2:
            heard += client.hears()
        assert re.fullmatch(r"< ok >< error 000 \d+\.\d{6} no channel is open >", heard)
        heard = ""
        while heard.count(">") < 2:
            heard += other.hears()
        assert re.fullmatch(r"< frame 001 \d+\.\d{6}  >< frame 00000001 \d+\.\d{6} 0ABC >", heard)


def test_without_a_channel_there_is_no_bus(port) -> None:
    with raw(port) as client:
        assert "no channel is open" in client.asks("< rawmode >")
        assert "no channel is open" in client.asks("< send 123 0 >")


def test_a_frame_that_python_can_cannot_say_is_an_error_frame_to_its_sender(bus) -> None:
    """It sends a remote frame as data that is missing; after it, its client still works."""
    sender, listener = bus(), bus()
    sender.send(can.Message(arbitration_id=0x123, is_extended_id=False, is_remote_frame=True, dlc=4))
    heard = sender.recv(PATIENCE_S)
    assert heard is not None
    assert heard.is_error_frame
    listener.send(message(3))
    assert same(sender.recv(PATIENCE_S), message(3))


def test_a_client_that_does_not_read_stalls_nobody_and_loses_whole_frames() -> None:
    told: list[str] = []
    hub = Hub(told.append, limit_bytes=100_000)
    block = "".join(f"< send 123 2 {k >> 8:x} {k & 255:x} >" for k in range(1000))
    with hub_running(hub) as port, raw(port) as sender, raw(port) as good, raw(port, 4096) as slow:
        for client in (sender, good, slow):
            client.joins()
        sent = 0
        while hub.dropped < 15_000:
            sender.says(block)
            sent += 1000
            assert sent < 1_000_000
            heard = 0
            while heard < 1000:
                heard += good.hears().count(">")
        waiting = [client.transport.get_write_buffer_size() for client in hub.clients]
        assert max(waiting) <= 100_000
        assert re.fullmatch(r"127\.0\.0\.1:\d+ reads too slowly: \d+ frames dropped for it so far", told[0])
        assert len(told) < 10
        text = ""
        while text.count(">") < sent - hub.dropped:
            text += slow.hears()
        assert re.fullmatch(r"(< frame 123 \d+\.\d{6} [0-9A-F]{4} >)+", text)
        assert text.count(">") == sent - hub.dropped
        sender.says("< send 124 0 >")
        assert " 124 " in slow.hears()
    assert f"{hub.dropped} frames dropped" in told[-1]


def test_a_client_that_goes_away_is_forgotten(port, hub) -> None:
    leaves = "import can, os, signal; can.Bus(interface='socketcand', channel='can0', host='127.0.0.1', port={})"
    with raw(port) as client:
        client.joins()
        ended("-c", leaves.format(port) + "; os.kill(os.getpid(), signal.SIGKILL)")
        with raw(port) as short:
            short.joins()
            assert len(hub.clients) >= 2
        until(lambda: len(hub.clients) == 1)
        client.says("< send 123 0 >")
        assert client.asks("< echo >") == "< echo >"


def test_a_hub_ends_with_clients_on_it() -> None:
    with hub_running() as port:
        client = Raw(port)
    with client.socket:
        assert client.socket.recv(1) == b""


def test_stamps_never_go_back_and_never_stand_still() -> None:
    wall, steady = 1_700_000_000_000_000_000, 5_000_000_000
    stamp = Stamp()

    def at(wall_s: float, steady_s: float) -> bytes:
        with (
            mock.patch("time.time_ns", return_value=wall + round(wall_s * 1e9)),
            mock.patch("time.monotonic_ns", return_value=steady + round(steady_s * 1e9)),
        ):
            return stamp.next()

    assert at(0.0, 0.0) == b"1700000000.000000"
    assert at(0.0, 0.0) == b"1700000000.000001"
    assert at(0.5, 0.5) == b"1700000000.500000"
    assert at(-3600.0, 1.0) == b"1700000001.000000"  # set back by an hour
    assert at(-3598.75, 2.25) == b"1700000002.250000"
    assert at(100.0, 3.0) == b"1700000100.000000"  # set ahead


def test_a_port_in_use_is_one_line(port) -> None:
    with pytest.raises(SetupError) as error, hub_running(port=port):
        pass
    assert str(error.value) == (
        f"port {port} on 127.0.0.1 cannot be used: address already in use; name another with --port or --bind"
    )


@pytest.mark.parametrize(("closing", "waiting"), [(True, 0), (False, 8_000_000)], ids=["gone", "reads nothing"])
def test_answers_to_a_client_that_does_not_take_them_are_dropped(hub, closing, waiting) -> None:
    """asyncio would tell of each, thousands at once, or keep them all."""
    client = _Client(hub)
    client.connection_made(transport := mock.create_autospec(asyncio.Transport))
    transport.is_closing.return_value, transport.get_write_buffer_size.return_value = closing, waiting
    transport.write.reset_mock()
    client.data_received(b"< open can0 >< echo >< send nonsense >" * 100)
    client.hear(b"< frame 123 1.0 11 >", 1)
    transport.write.assert_not_called()
    assert hub.dropped == (not closing)
