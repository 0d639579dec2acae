"""The frames of a run: every signal packed as the DBC lays it out, in order of time.

Packed with numpy, not frame by frame: a slow run has over half a million drive frames. A test holds the bytes equal to
what cantools encodes from the DBC.
"""

from collections.abc import Iterator
from typing import NamedTuple

import can
import numpy as np
from crccheck.crc import Crc8SaeJ1850, Crc16CcittFalse
from numpy.typing import ArrayLike

from drivers.virtual_rig.run import Run
from drivers.virtual_rig.sensors.probes import Reading

EPOCH_S = 1_700_000_000.0  # time stamp of the first frame
TELEMETER_IDS = (0x210, 0x211, 0x212, 0x213)
STATUS_ID = 0x214
HOLD_ID, DIRECT_ID = 0x220, 0x221
DRIVE_ID = 0x230
ENVIRONMENT_IDS = (0x240, 0x241)
DRIVE_HZ = 100
GAP_S = 0.0003  # between the frames of one tick; a frame lasts 0.25 ms at 500 kbit/s
STANDSTILL, MOVING = 1, 2
COUNTER = 15


class FrameTable(NamedTuple):
    """All frames: rig time (n,) s, identifier (n,), payload (n, 8)"""

    time_s: np.ndarray
    id: np.ndarray
    data: np.ndarray

    def messages(self, began_s: float = EPOCH_S) -> Iterator[can.Message]:
        """The frames as python-can's messages, stamped with a fixed epoch plus the rig's time."""
        for t, frame_id, data in zip(self.time_s.tolist(), self.id.tolist(), self.data, strict=True):
            yield can.Message(began_s + t, frame_id, is_extended_id=False, data=data.tobytes())


def frame_table(run: Run) -> FrameTable:
    """Frames of all units, in order of time; of each tick the telemeter's status comes last."""
    ticks = run.measured.time_s
    units = [
        _drive(run),
        _environment(run, ticks + GAP_S),
        _displacement(DIRECT_ID, ticks + 3 * GAP_S, run.measured.direct),
        _telemeter(run, ticks + 4 * GAP_S),
        _displacement(HOLD_ID, run.holds.frozen_s, run.holds.reading),
    ]
    time_s, ids, data = (np.concatenate(column) for column in zip(*units, strict=True))
    order = np.argsort(time_s, kind="stable")
    last = status_times(ticks)[-1]
    order = order[time_s[order] <= last]
    return FrameTable(time_s[order], ids[order], data[order])


def status_times(ticks: np.ndarray) -> np.ndarray:
    """When the frame that closes each tick is sent, rig time in s"""
    return ticks + 8 * GAP_S


def _telemeter(run: Run, start: np.ndarray) -> FrameTable:
    """Four frames of four temperatures, then the status with its counters and checksums."""
    degrees = np.column_stack([run.measured.channels, run.measured.board])
    scan = _int16(degrees / 0.01)
    number = np.arange(len(scan))
    status = np.zeros((len(scan), 8), dtype=np.uint8)
    status[:, 1] = (number % COUNTER) | (1 << 4)
    status[:, 2:4] = _little(number & 0xFFFF, 2)
    status[:, 6:8] = _little([Crc16CcittFalse.calc(row.tobytes()) for row in scan], 2)
    head = STATUS_ID.to_bytes(2, "little")
    status[:, 0] = [Crc8SaeJ1850.calc(head + row[1:].tobytes()) for row in status]
    blocks = [scan[:, 8 * k : 8 * k + 8] for k in range(4)] + [status]
    return _stacked([start + k * GAP_S for k in range(5)], (*TELEMETER_IDS, STATUS_ID), blocks)


def _environment(run: Run, start: np.ndarray) -> FrameTable:
    degrees = _int16(np.column_stack(run.measured.environment) / 0.01)
    second = np.zeros((len(degrees), 8), dtype=np.uint8)
    second[:, :6] = degrees[:, 8:]
    second[:, 7] = np.arange(len(degrees)) % COUNTER
    return _stacked([start, start + GAP_S], ENVIRONMENT_IDS, [degrees[:, :8], second])


def _displacement(frame_id: int, time_s: np.ndarray, reading: Reading) -> FrameTable:
    data = np.zeros((len(time_s), 8), dtype=np.uint8)
    data[:, 0] = np.arange(len(time_s)) & 0xFF
    data[:, 1] = reading.state
    data[:, 2:5] = _little(np.round(reading.a1b1 / 0.001), 3)
    data[:, 5:8] = _little(np.round(reading.a2b2 / 0.001), 3)
    return _stacked([time_s], (frame_id,), [data])


def _drive(run: Run) -> FrameTable:
    signals = run.drive(drive_times(run))
    state = np.where(signals.moving, MOVING, STANDSTILL)
    current = np.clip(np.round(signals.current_a / 0.01), -2048, 2047).astype(np.int64) & 0xFFF
    data = np.zeros((len(state), 8), dtype=np.uint8)
    data[:, :3] = _little(np.round(signals.position_mm / 0.0001), 3)
    data[:, 3:5] = _little(np.round(signals.speed_rpm / 0.1), 2)
    data[:, 5:7] = _little(current | (state << 12), 2)
    data[:, 7] = np.arange(len(state)) % COUNTER
    return _stacked([signals.time_s], (DRIVE_ID,), [data])


def drive_times(run: Run) -> np.ndarray:
    """Each second, and each 10 ms from a drive's start until it has just ended."""
    ticks = run.measured.time_s
    fast = [
        np.arange(round(drive.start_s * DRIVE_HZ), np.ceil(min(drive.stop_s, ticks[-1]) * DRIVE_HZ) + 1)
        for drive in run.travel.drives
    ]
    return np.unique(np.concatenate([ticks * DRIVE_HZ, *fast])) / DRIVE_HZ


def _int16(values: np.ndarray) -> np.ndarray:
    """Two bytes for each value, side by side: (n, m) -> (n, 2 m)"""
    return np.round(values).astype("<i2").view(np.uint8).reshape(len(values), -1)


def _little(values: ArrayLike, width: int) -> np.ndarray:
    """The low bytes of each value, lowest first: (n, width)"""
    return np.ascontiguousarray(values, dtype="<i8").view(np.uint8).reshape(-1, 8)[:, :width]


def _stacked(times: list[np.ndarray], ids: tuple[int, ...], blocks: list[np.ndarray]) -> FrameTable:
    counts = [len(t) for t in times]
    return FrameTable(np.concatenate(times), np.repeat(np.array(ids), counts), np.concatenate(blocks))
