"""Checksums and counters of frames and scans, whole arrays at once."""

import numpy as np
from crccheck.crc import Crc8SaeJ1850, Crc16CcittFalse
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]


# What each byte adds; the library itself goes byte by byte.
_CRC8 = np.array([Crc8SaeJ1850.calc([byte], 0) ^ 0xFF for byte in range(256)], np.uint16)
_CRC16 = np.array([Crc16CcittFalse.calc([byte], 0) for byte in range(256)], np.uint16)


def crc8_j1850(data: Bytes) -> NDArray[np.uint16]:
    """CRC-8/SAE-J1850 of each row of (n, bytes): (n,)."""
    crc = np.full(len(data), 0xFF, np.uint16)
    for column in data.T:
        crc = _CRC8[crc ^ column]
    return crc ^ np.uint16(0xFF)


def crc16_ccitt_false(data: Bytes) -> NDArray[np.uint16]:
    """CRC-16/CCITT-FALSE of each row of (n, bytes): (n,)."""
    crc = np.full(len(data), 0xFFFF, np.uint16)
    for column in data.T:
        crc = (crc << np.uint16(8)) ^ _CRC16[(crc >> np.uint16(8)) ^ column]
    return crc


def frame_checksum(can_id: int, data: Bytes) -> NDArray[np.uint16]:
    """What byte 0 of each frame (n, bytes) must hold: over the id's low and high byte, then bytes 1 ..."""
    head = np.broadcast_to(np.array([can_id & 0xFF, can_id >> 8 & 0xFF], np.uint8), (len(data), 2))
    return crc8_j1850(np.concatenate([head, data[:, 1:]], axis=1))


def lost(numbers: NDArray[np.int64], before: int | None, modulus: int) -> int:
    """How many frames are missing between these counter values, (n,), and the one before, at least.

    A step back by one is a frame out of order: it was counted as missing, so it counts back.
    """
    if before is not None:
        numbers = np.concatenate(([before], numbers))
    steps = np.diff(numbers) % modulus
    steps[steps == modulus - 1] = -1
    return int(np.sum(steps[steps != 0] - 1))
