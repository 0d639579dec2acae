"""SocketCAN's buffer in the kernel: made larger, and asked how many frames it had no room for.

The default holds 278 frames, 35 ms of a full bus; a process that is not given the processor for longer loses the rest
and never hears of it.
"""

import socket
import struct
from contextlib import suppress
from typing import Any

ROOM = 8 << 20  # bytes: some seconds of a full bus
SO_RXQ_OVFL, SO_RCVBUFFORCE = 40, 33  # of Linux; the module socket does not name them
_COUNT = struct.Struct("I")


class Counted:
    """A socket that counts in `lost` what the kernel dropped, and is else the socket itself.

    The count comes beside a frame, next to its time stamp; python-can refuses what it did not ask for.
    """

    def __init__(self, socket_: Any) -> None:
        self.lost = 0
        self._socket = socket_

    def __getattr__(self, name: str) -> Any:
        return getattr(self._socket, name)

    def recvmsg(self, size: int, beside: int) -> tuple[bytes, list[tuple[int, int, bytes]], int, Any]:
        """As the socket's own, with room for the count, which is kept here."""
        data, said, flags, sender = self._socket.recvmsg(size, beside + socket.CMSG_SPACE(_COUNT.size))
        rest = []
        for level, kind, value in said:
            if (level, kind) == (socket.SOL_SOCKET, SO_RXQ_OVFL):
                (self.lost,) = _COUNT.unpack_from(value)
            else:
                rest.append((level, kind, value))
        return data, rest, flags, sender


def with_room(bus: Any) -> Counted | None:
    """Give the bus a large buffer and have what it loses counted; None for what is no SocketCAN."""
    found = getattr(bus, "socket", None)
    if not isinstance(found, socket.socket) or found.family != getattr(socket, "AF_CAN", None):
        return None
    return counted(bus, found)


def counted(bus: Any, found: Any) -> Counted:
    """Put the counting socket in the place of the one found."""
    with suppress(OSError):
        found.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, ROOM)  # up to net.core.rmem_max
    with suppress(OSError):
        found.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, ROOM)  # beyond it, where we may
    with suppress(OSError):
        found.setsockopt(socket.SOL_SOCKET, SO_RXQ_OVFL, 1)
    bus.socket = Counted(found)
    return bus.socket
