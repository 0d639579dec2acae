"""One frame as a line of candump text, and back: every kind of frame, not only those that an estimate uses.

(1699999999.123456) can0 210#0011223344556677     data; an extended id has eight digits
(1699999999.123456) can0 210#R8                   remote frame and its data length code
(1699999999.123456) can0 210##1001122             FD frame, after its flags
(1699999999.123456) can0 20000080#0000000000000000  error frame: its class bits, marked, and its details
"""

import re

from drivers.received import Received

ERROR_FLAG = 0x20000000
_LINE = re.compile(
    r" *\((\d{1,10}\.\d{1,9})\) +(\S+) +([0-9A-Fa-f]{8}|[0-9A-Fa-f]{3})#"
    r"(?:R([0-8]?)|#([0-9A-Fa-f])((?:[0-9A-Fa-f]{2}){0,64})|((?:[0-9A-Fa-f]{2}){0,8}))(?: [RT])?\s*"
)


def line_of(frame: Received) -> str:
    """The frame as candump -L writes it, with its line end."""
    head = f"({frame.time_s:.6f}) {frame.channel.replace(' ', '_') or 'can0'}"
    if frame.kind == "data":
        rest = f"#{frame.data.hex().upper()}"
    elif frame.kind == "remote":
        rest = f"#R{frame.dlc or ''}"
    elif frame.kind == "fd":
        rest = f"##{frame.flags & 15:X}{frame.data.hex().upper()}"
    else:
        return f"{head} {ERROR_FLAG | frame.id:08X}#{frame.data.hex().upper()}\n"
    number = f"{frame.id:08X}" if frame.extended else f"{frame.id:03X}"
    return f"{head} {number}{rest}\n"


def frame_of(line: str) -> Received | None:
    """The frame of one whole line; None if the line is none."""
    match = _LINE.fullmatch(line)
    if match is None:
        return None
    stamp, channel, digits, remote, flags, long, short = match.groups()
    number, extended = int(digits, 16), len(digits) == 8
    data = bytes.fromhex(short or long or "")
    frame = Received(float(stamp), number, extended, data, "data", channel, len(data))
    if remote is not None:
        return frame._replace(kind="remote", dlc=int(remote or 0))
    if flags is not None:
        return frame._replace(kind="fd", flags=int(flags, 16))
    if extended and number & ERROR_FLAG:
        return frame._replace(kind="error", id=number & ~ERROR_FLAG)
    return frame
