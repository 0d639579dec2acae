"""What every receiver hands on, whatever the interface: frames as they came off a bus, and sentences about the bus."""

from typing import NamedTuple

from drivers.canbus import can


class Received(NamedTuple):
    """One frame as it came off a bus.

    time_s    s since 1970 on the rig's clock, whole microseconds
    id        11 or 29 bits; of an error frame its class bits
    extended  29-bit id
    data      what the frame carried; of an error frame its details, of a remote frame nothing
    kind      "data", "remote", "error" or "fd"
    channel   the bus it was on
    dlc       data length code; all that a remote frame has beside its id
    flags     of an FD frame: 1 bit rate switched, 2 the sender is error passive
    """

    time_s: float
    id: int
    extended: bool
    data: bytes
    kind: str = "data"
    channel: str = "can0"
    dlc: int = 0
    flags: int = 0


class Notice(NamedTuple):
    """A sentence about the bus itself; level is INFO or WARN."""

    text: str
    level: str = "WARN"


def received_of(message: can.Message, time_s: float, channel: str) -> Received:
    """A message of python-can, stamped `time_s` (s since 1970), on this channel."""
    kind = "data"
    if message.is_error_frame:
        kind = "error"
    elif message.is_remote_frame:
        kind = "remote"
    elif message.is_fd:
        kind = "fd"
    return Received(
        round(time_s, 6),
        message.arbitration_id,
        message.is_extended_id,
        b"" if kind == "remote" else bytes(message.data),
        kind,
        channel,
        message.dlc,
        message.bitrate_switch | message.error_state_indicator << 1,
    )
