"""A rig on a bus that is not there: frames of the virtual rig as a receiver hands them on, and faults to put in."""

import struct
from collections.abc import Callable, Iterable

import numpy as np

from ballscrew.monitor.monitor import Moment, Monitor
from drivers.decode.checks import crc16_ccitt_false, frame_checksum
from drivers.received import Received
from drivers.virtual_rig import frame_table, simulate

TELEMETERS = range(0x210, 0x214)
STATUS, DRIVE = 0x214, 0x230
Frames = list[Received]
Change = Callable[[bytearray, float], None]


def rig_frames(seconds: float, seed: int = 7, **options: object) -> Frames:
    """What the rig sends, FS-20 from its start."""
    sent = frame_table(simulate("FS-20", seed=seed, seconds=seconds, **options)).messages()
    return [Received(round(m.timestamp, 6), m.arbitration_id, False, bytes(m.data)) for m in sent]


def since(frames: Frames, frame: Received) -> float:
    """Time of a frame after the first, s."""
    return frame.time_s - frames[0].time_s


def dropped(frames: Frames, begin_s: float, ids: Iterable[int] | None = None, end_s: float = np.inf) -> Frames:
    """Without these messages, or any, in a span."""
    gone = set(ids) if ids is not None else None
    return [f for f in frames if not (begin_s <= since(frames, f) < end_s and (gone is None or f.id in gone))]


def changed(frames: Frames, can_id: int, begin_s: float, change: Change) -> Frames:
    """One message's data changed from a time on; checksums of telemeter scans are right again."""
    found = []
    for frame in frames:
        at = since(frames, frame)
        if frame.id == can_id and at >= begin_s:
            data = bytearray(frame.data)
            change(data, at)
            frame = frame._replace(data=bytes(data))
        found.append(frame)
    return checked(found)


def checked(frames: Frames) -> Frames:
    """Scan checksums as the data now have them."""
    scan: dict[int, bytes] = {}
    found = []
    for frame in frames:
        if frame.id in TELEMETERS:
            scan[frame.id] = frame.data
        elif frame.id == STATUS and len(scan) == len(TELEMETERS):
            data = bytearray(frame.data)
            whole = np.frombuffer(b"".join(scan[i] for i in TELEMETERS), np.uint8)[None]
            data[6:8] = struct.pack("<H", int(crc16_ccitt_false(whole)[0]))
            data[0] = int(frame_checksum(STATUS, np.array([data], np.uint8))[0])
            frame = frame._replace(data=bytes(data))
        found.append(frame)
    return found


def channel(number: int, raw: Callable[[int, float], int]) -> tuple[int, Change]:
    """The message of thermometer 1 ... 15, and a change of its raw value: raw(value, time)."""
    at = (number - 1) % 4

    def change(data: bytearray, time_s: float) -> None:
        (value,) = struct.unpack_from("<h", data, 2 * at)
        struct.pack_into("<h", data, 2 * at, raw(value, time_s))

    return TELEMETERS[(number - 1) // 4], change


def lived(monitor: Monitor, frames: Frames) -> list[Moment]:
    """All moments of a monitor that is fed these frames."""
    return [*(moment for frame in frames for moment in monitor.feed(frame)), *monitor.finish()]
