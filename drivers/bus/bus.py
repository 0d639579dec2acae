"""A bus to listen on: any interface of python-can, without a way to transmit."""

import logging
import socket
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from drivers.bus.kernel_buffer import with_room
from drivers.canbus import can
from estimator.errors import SetupError

# What interfaces raise beside can.CanError: it depends on the driver, the adaptor and the state of its cable.
FAILURES = (can.CanError, OSError, ValueError, TypeError, AttributeError, NotImplementedError, EOFError)
CONNECT_S = 2.0


@dataclass(frozen=True)
class BusAddress:
    """Where a bus is, as python-can names it; `options` are the interface's own, like host=127.0.0.1."""

    interface: str | None
    channel: str | None = None
    bitrate: int | None = None
    options: Mapping[str, str | int | float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The channel, as a log calls it: without blanks."""
        return "_".join((self.channel or self.interface or "can").split())

    def __str__(self) -> str:
        return " ".join([self.interface or "bus", self.channel or "", *(f"{k}={v}" for k, v in self.options.items())])

    def open(self) -> can.BusABC:
        """The bus itself, transmitting included; a name that python-can does not know is a SetupError."""
        logging.getLogger("can").setLevel(logging.CRITICAL)  # it would write into our status
        if self.interface == "socketcand":
            self._reach()
        options: dict[str, Any] = dict(self.options)
        if self.bitrate is not None:
            options["bitrate"] = self.bitrate
        try:
            return can.Bus(channel=self.channel, interface=self.interface, **options)
        except can.CanInterfaceNotImplementedError as error:
            raise SetupError(f"--interface {self.interface}: {error}") from error

    def listen(self) -> "Listener":
        """The bus without a way to transmit."""
        bus = self.open()
        buffer = with_room(bus)
        return Listener(bus, lambda: buffer.lost if buffer else 0)

    def _reach(self) -> None:
        # python-can spins on a port where nobody listens, for ten seconds, and waits for ever for one who says nothing
        host, port = self.options.get("host"), self.options.get("port")
        if host is None or not isinstance(port, int):
            raise SetupError("--interface socketcand: say where: --bus-kwargs host=127.0.0.1 port=28600")
        with socket.create_connection((str(host), port), CONNECT_S) as probe:
            probe.settimeout(CONNECT_S)
            if not probe.recv(16):
                raise ConnectionError(f"{host}:{port} hangs up")


class Listener:
    """A bus of which only listening is left: no code path of the monitor can transmit by it.

    lost  says how many frames the kernel had no room for
    """

    def __init__(self, bus: can.BusABC, lost: Callable[[], int] = lambda: 0) -> None:
        self.recv: Callable[[float], can.Message | None] = bus.recv
        self.shutdown: Callable[[], None] = bus.shutdown
        self.lost = lost


def told(error: BaseException) -> str:
    """What an interface raised, in one line: python-can puts whole tracebacks into its messages."""
    text = str(error).partition("Traceback (most recent call last)")[0]
    return f"{type(error).__name__}: {' '.join(text.split())}"


def hang_up(bus: Listener | can.BusABC | None) -> None:
    """Close a bus that is open; one that is gone cannot be closed either."""
    if bus is not None:
        with suppress(Exception):
            bus.shutdown()


def bus_options(words: tuple[str, ...]) -> dict[str, str | int | float]:
    """K=V ... of the command line as options of an interface: numbers and booleans as such, the rest as text."""
    wrong = [word for word in words if "=" not in word]
    if wrong:
        raise SetupError(f"--bus-kwargs {wrong[0]}: write NAME=VALUE, for example host=127.0.0.1")
    return {key: can.util.cast_from_string(value) for key, _, value in (word.partition("=") for word in words)}
