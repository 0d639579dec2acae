"""Where to listen: one address of this machine, by default the loopback, and a port that nobody uses."""

import ipaddress
import socket

from estimator.errors import SetupError

LOOPBACK = "127.0.0.1"


def free_port() -> int:
    """A port that nobody uses now."""
    return port_at(LOOPBACK, 0)


def port_at(bind: str, port: int) -> int:
    """The port to listen on: `port`, or any free one if it is 0; SetupError if nobody can listen there.

    Who listens gives what it has to everybody who can reach the address, so all addresses at once are refused.
    """
    try:
        address = ipaddress.IPv4Address(bind)
    except ValueError:
        raise SetupError(f"bind {bind}: not an IPv4 address; this machine alone is {LOOPBACK}") from None
    if address.is_unspecified or address.is_multicast:
        raise SetupError(f"bind {bind}: not one address; this machine alone is {LOOPBACK}")
    if not 0 <= port <= 65535:
        raise SetupError(f"port {port}: not between 0 (any free one) and 65535")
    try:
        with socket.create_server((bind, port)) as probe:
            return int(probe.getsockname()[1])
    except OSError as error:
        why = error.strerror or error
        raise SetupError(f"{bind}:{port}: cannot listen there ({why}); choose another port, 0 takes any") from error
