"""SocketCAN's buffer: enlarged, and its losses counted. There may be no CAN here: another socket overflows as well."""

import socket
import struct
import sys
from contextlib import suppress
from types import SimpleNamespace

import pytest

from drivers.bus.kernel_buffer import SO_RCVBUFFORCE, SO_RXQ_OVFL, counted, with_room

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="SocketCAN is Linux")
TIMESTAMPNS = 35


class Raw:
    """A raw CAN socket with one frame, stamped 1.5 s after 1970."""

    def __init__(self, *refused: int) -> None:
        self.refused, self.options = refused, {}

    def setsockopt(self, level: int, option: int, value: int) -> None:
        if option in self.refused:
            raise PermissionError(1, "Operation not permitted")
        self.options[option] = value

    def recvmsg(self, size: int, beside: int) -> tuple:
        frame = struct.pack("=IBBBB8s", 0x214, 8, 0, 0, 0, b"12345678")
        stamp = (socket.SOL_SOCKET, TIMESTAMPNS, struct.pack("@ll", 1, 500_000_000))
        assert beside >= socket.CMSG_SPACE(16) + socket.CMSG_SPACE(4)
        return frame, [stamp, (socket.SOL_SOCKET, SO_RXQ_OVFL, struct.pack("I", 903))], 0, ("can0",)


def test_python_can_reads_on_and_the_loss_is_counted():
    from can.interfaces.socketcan.socketcan import capture_message

    bus = SimpleNamespace()
    buffer = counted(bus, Raw())
    message = capture_message(bus.socket)
    assert (message.arbitration_id, message.timestamp, bytes(message.data)) == (0x214, 1.5, b"12345678")
    assert buffer.lost == 903
    assert bus.socket is buffer
    assert buffer.options[SO_RCVBUFFORCE] == buffer.options[socket.SO_RCVBUF] == 8 << 20


@pytest.mark.parametrize("refused", [(SO_RCVBUFFORCE,), (SO_RCVBUFFORCE, socket.SO_RCVBUF, SO_RXQ_OVFL)])
def test_who_may_not_have_a_large_buffer_has_another(refused):
    raw = Raw(*refused)
    counted(SimpleNamespace(), raw)
    assert set(raw.options) == {SO_RXQ_OVFL, socket.SO_RCVBUF} - {*refused}


def test_a_socket_that_overflows_says_how_much_it_lost():
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as inside,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
    ):
        inside.bind(("127.0.0.1", 0))
        buffer = counted(SimpleNamespace(), inside)
        assert inside.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) > 212_992  # what it has by default
        inside.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        for _ in range(500):
            sender.sendto(bytes(100), inside.getsockname())
        inside.setblocking(False)
        came = 0
        with suppress(BlockingIOError):
            while buffer.recvmsg(100, 64):
                came += 1
        sender.sendto(bytes(100), inside.getsockname())
        buffer.recvmsg(100, 64)
        assert came + buffer.lost == 500
        assert buffer.lost > 100


def test_what_is_no_socketcan_stays_as_it_is():
    bus = SimpleNamespace(socket=socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
    with bus.socket as before:
        assert with_room(bus) is None
        assert bus.socket is before
    assert with_room(SimpleNamespace()) is None
