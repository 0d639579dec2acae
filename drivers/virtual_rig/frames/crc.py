"""The two checksums of the telemeter's frames, over many rows of bytes at once."""

import numpy as np


def crc8_j1850(rows: np.ndarray) -> np.ndarray:
    """CRC-8/SAE-J1850 (polynomial 0x1D, start 0xFF, inverted at the end) of each row of bytes: (n,)"""
    crc = np.full(len(rows), 0xFF, dtype=np.uint8)
    for column in rows.T:
        crc = _TABLE_8[crc ^ column]
    return crc ^ np.uint8(0xFF)


def crc16_ccitt_false(rows: np.ndarray) -> np.ndarray:
    """CRC-16/CCITT-FALSE (polynomial 0x1021, start 0xFFFF) of each row of bytes: (n,)"""
    crc = np.full(len(rows), 0xFFFF, dtype=np.uint16)
    for column in rows.T:
        crc = (crc << np.uint16(8)) ^ _TABLE_16[(crc >> np.uint16(8)) ^ column]
    return crc


def _table(polynomial: int, bits: int) -> np.ndarray:
    """Remainders of the 256 leading bytes."""
    top, mask = 1 << (bits - 1), (1 << bits) - 1
    remainders = []
    for byte in range(256):
        crc = byte << (bits - 8)
        for _ in range(8):
            crc = ((crc << 1) ^ polynomial) & mask if crc & top else (crc << 1) & mask
        remainders.append(crc)
    return np.array(remainders)


_TABLE_8 = _table(0x1D, 8).astype(np.uint8)
_TABLE_16 = _table(0x1021, 16).astype(np.uint16)
