"""A CAN bus between programs of one machine, without CAN hardware: a TCP hub that speaks the socketcand protocol.

A client says `< open can0 >`, `< rawmode >` and `< send 123 2 11 22 >`; all others on can0 then hear
`< frame 123 1699999999.123456 1122 >`. python-can's interface `socketcand` is such a client.
"""

import asyncio
import re
import socket
import time
from collections.abc import Callable
from contextlib import suppress

from estimator.errors import SetupError

_SEND = re.compile(rb"send ([0-9A-Fa-f]{1,3}|[01][0-9A-Fa-f]{7}) ([0-8])((?: +[0-9A-Fa-f]{1,2})*) *")
_LONGEST = 4096  # bytes of one command
_QUICK_ACK = getattr(socket, "TCP_QUICKACK", 0)
_TELL_S = 5.0  # between two sentences about the same slow client


class Hub:
    """The clients by channel.

    tell         is told, in one sentence, when a client is too slow
    limit_bytes  how much may wait for one client; what comes beyond it is dropped for this client
    frames       taken so far
    dropped      frames that slow clients did not get
    """

    def __init__(self, tell: Callable[[str], None] = lambda sentence: None, limit_bytes: int = 8_000_000) -> None:
        self.tell = tell
        self.limit_bytes = limit_bytes
        self.frames = self.dropped = 0
        self.clients: set[_Client] = set()
        self.stamp = Stamp()

    async def open(self, host: str = "127.0.0.1", port: int = 0) -> int:
        """Listen; returns the port, any free one for port 0. One that cannot be used is a SetupError."""
        try:
            self._server = await asyncio.get_running_loop().create_server(lambda: _Client(self), host, port)
        except OSError as error:  # "... on address (...): [errno 98] address already in use", from Python 3.13 on
            why = (error.strerror or str(error)).rpartition(": ")[2].rpartition("] ")[2].lower()
            raise SetupError(
                f"port {port} on {host} cannot be used: {why}; name another with --port or --bind"
            ) from None
        return int(self._server.sockets[0].getsockname()[1])

    async def close(self) -> None:
        """No more clients; returns when the last one is gone."""
        self._server.close()
        for client in self.clients:
            client.transport.abort()
        while self.clients:
            await asyncio.sleep(0)

    def pass_on(self, sender: "_Client", frames: list[tuple[bytes, bytes]]) -> None:
        """Stamp frames, (id, data) as hex, and hand them to everybody else on the sender's channel."""
        text = b"".join(b"< frame %b %b %b >" % (number, self.stamp.next(), data) for number, data in frames)
        self.frames += len(frames)
        for client in self.clients:
            if client is not sender and client.listens_to == sender.channel:
                client.hear(text, len(frames))


class _Client(asyncio.Protocol):
    """One connection: its commands in, the frames of the others out."""

    transport: asyncio.Transport

    def __init__(self, hub: Hub) -> None:
        self.hub = hub
        self.channel = self.listens_to = b""
        self._rest = b""
        self._mark = False
        self._dropped = self._told = 0
        self._tell_at = 0.0

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self.transport = transport
        self._socket = transport.get_extra_info("socket")
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.hub.clients.add(self)
        self._answer(b"< hi >")

    def connection_lost(self, error: Exception | None) -> None:
        self.hub.clients.discard(self)
        if self._dropped > self._told:
            self._tell()

    def data_received(self, data: bytes) -> None:
        if _QUICK_ACK:
            # a client that collects small writes (Nagle) waits for this before it sends the next: 40 ms by default
            self._socket.setsockopt(socket.IPPROTO_TCP, _QUICK_ACK, 1)
        *commands, self._rest = (self._rest + data).split(b">")
        frames = []
        for command in commands:
            words = command[command.rfind(b"<") + 1 :].strip()
            if self.channel and (frame := _frame(words)):
                frames.append(frame)
                continue
            self._pass_on(frames)
            frames = []
            self._obey(words)
        self._pass_on(frames)
        if len(self._rest) > _LONGEST:
            self._rest = b""
            self._refuse("no command is as long")

    def _pass_on(self, frames: list[tuple[bytes, bytes]]) -> None:
        if frames:
            self.hub.pass_on(self, frames)

    def hear(self, text: bytes, count: int) -> None:
        """Pass on frames; a client that does not read them must neither stall the others nor fill the memory."""
        if self._mark:
            self._end_reply()
        if self._answer(text):
            return
        self._dropped += count
        self.hub.dropped += count
        if time.monotonic() >= self._tell_at:
            self._tell()

    def _answer(self, text: bytes) -> bool:
        """Send it; False where too much waits already. A client that is gone need not be told, nor be told of."""
        if self.transport.is_closing():
            return True
        if self.transport.get_write_buffer_size() + len(text) > self.hub.limit_bytes:
            return False
        self.transport.write(text)
        return True

    def _obey(self, words: bytes) -> None:
        name, *rest = words.split() or [b""]
        if name == b"open" and len(rest) == 1:
            self.channel, self.listens_to = rest[0], b""
            self._answer(b"< ok >")
        elif name == b"rawmode" and self.channel:
            self._answer(b"< ok >")
            self.listens_to, self._mark = self.channel, True
        elif name == b"close":
            self.channel = self.listens_to = b""
            self._answer(b"< ok >")
        elif name == b"echo":
            self._answer(b"< echo >")
        elif name in (b"send", b"rawmode") and not self.channel:
            self._refuse("no channel is open")
        elif name == b"send":
            self._refuse("a frame is an id of 3 or 8 digits, a length to 8 and as many bytes, all hex")
        elif name != b"statistics":
            self._refuse("known are open CHANNEL, rawmode, send, echo, close")

    def _end_reply(self) -> None:
        # python-can takes one recv for the reply to rawmode and nothing else. No recv reads on over TCP's urgent mark,
        # so that the first frame cannot be glued to it; the marked byte itself is left out of the stream.
        self._mark = False
        with self._socket.dup() as twin, suppress(OSError):
            twin.send(b" ", socket.MSG_OOB)

    def _refuse(self, why: str) -> None:
        # The id and time of an error frame come first: python-can's client dies of an error that has none.
        self._answer(b"< error 000 %b %b >" % (self.hub.stamp.next(), why.encode()))

    def _tell(self) -> None:
        peer = ":".join(map(str, (self.transport.get_extra_info("peername") or ["a client"])[:2]))
        self.hub.tell(f"{peer} reads too slowly: {self._dropped} frames dropped for it so far")
        self._told = self._dropped
        self._tell_at = time.monotonic() + _TELL_S


def _frame(words: bytes) -> tuple[bytes, bytes] | None:
    """Id and data of a send command, as hex of full width; None if it is none, or a wrong one."""
    match = _SEND.fullmatch(words)
    if match is None:
        return None
    number, size, data = match.groups()
    digits = [digit.zfill(2) for digit in data.split()]
    if len(digits) != int(size) or (len(number) < 8 and int(number, 16) > 0x7FF):
        return None
    return number.zfill(3).upper(), b"".join(digits).upper()


class Stamp:
    """Wall time in whole microseconds that never goes back: when the clock is set back, it goes on steadily."""

    def __init__(self) -> None:
        self._ahead_ns = 0  # of the wall clock, against the steady one
        self._last_us = 0

    def next(self) -> bytes:
        """Later than every stamp before, s since 1970: "1699999999.123456"."""
        wall_ns = time.time_ns()
        steady_ns = time.monotonic_ns()
        self._ahead_ns = max(self._ahead_ns, wall_ns - steady_ns)
        self._last_us = max((steady_ns + self._ahead_ns) // 1000, self._last_us + 1)
        return b"%d.%06d" % divmod(self._last_us, 1_000_000)
