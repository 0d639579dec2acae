"""Messages into an ASAM MDF 4 file with CAN bus logging.

python-can's own writer takes a third of a millisecond a frame and counts time from the moment of writing; here frames
go in blocks, and the file starts when the first of them came. Imported only where asammdf is.
"""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import can
import numpy as np
from asammdf import MDF, Signal
from asammdf.blocks.v4_blocks import SourceInformation
from asammdf.blocks.v4_constants import BUS_TYPE_CAN, SOURCE_BUS
from can.io.mf4 import ERR_DTYPE, RTR_DTYPE, STD_DTYPE
from can.util import channel2int, len2dlc

_GROUPS = {"CAN_DataFrame": STD_DTYPE, "CAN_ErrorFrame": ERR_DTYPE, "CAN_RemoteFrame": RTR_DTYPE}
_BLOCK = 10_000
_SMALLEST = 2  # transposed and deflated


class Mf4Writer:
    """Takes messages like the writers of python-can; the file is written at `stop`."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._start: datetime | None = None
        self._mdf = MDF(version="4.10")
        source = SourceInformation(source_type=SOURCE_BUS, bus_type=BUS_TYPE_CAN)
        for name, dtype in _GROUPS.items():
            empty = np.array([], dtype=dtype)
            self._mdf.append(Signal(name=name, samples=empty, timestamps=np.array([], "<f8"), source=source))
        self._rows: list[list[tuple[float, can.Message]]] = [[] for _ in _GROUPS]

    def on_message_received(self, message: can.Message) -> None:
        """Append one message."""
        if self._start is None:
            self._start = datetime.fromtimestamp(int(message.timestamp), UTC)
            self._mdf.header.start_time = self._start
        group = 2 if message.is_remote_frame else 1 if message.is_error_frame else 0
        self._rows[group].append((message.timestamp - self._start.timestamp(), message))
        if len(self._rows[group]) >= _BLOCK:
            self._flush(group)

    def stop(self) -> None:
        """Write the file."""
        for group in range(len(_GROUPS)):
            self._flush(group)
        with self._path.open("wb+") as file:
            self._mdf.save(file, compression=_SMALLEST)
        self._mdf.close()

    def _flush(self, group: int) -> None:
        rows, self._rows[group] = self._rows[group], []
        if not rows:
            return
        name, dtype = list(_GROUPS.items())[group]
        samples = np.zeros(len(rows), dtype)
        for row, (_, message) in zip(samples, rows, strict=True):
            _fill(row, name, message)
        self._mdf.extend(group, [(np.array([time for time, _ in rows]), None), (samples, None)])


def _fill(row: Any, name: str, message: can.Message) -> None:
    row[f"{name}.BusChannel"] = channel2int(message.channel) or 0
    row[f"{name}.ID"] = message.arbitration_id
    row[f"{name}.IDE"] = message.is_extended_id
    row[f"{name}.DLC"] = len2dlc(message.dlc)
    if message.is_remote_frame:
        return
    row[f"{name}.DataLength"] = len(message.data)
    row[f"{name}.DataBytes"][: len(message.data)] = message.data
    row[f"{name}.EDL"] = message.is_fd
    row[f"{name}.BRS"] = message.bitrate_switch
    row[f"{name}.ESI"] = message.error_state_indicator
