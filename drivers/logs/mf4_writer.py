"""Messages into an ASAM MDF 4 file with CAN bus logging.

python-can's own writer takes a third of a millisecond a frame and counts time from the moment of writing; here frames
go in blocks, and the file starts when the first of them came. Imported only where asammdf is.
"""

from datetime import UTC, datetime
from importlib import reload
from pathlib import Path
from typing import Any

import numpy as np
from can.io import mf4

from drivers.canbus import can

reload(mf4)  # with asammdf
_GROUPS = {"CAN_DataFrame": mf4.STD_DTYPE, "CAN_ErrorFrame": mf4.ERR_DTYPE, "CAN_RemoteFrame": mf4.RTR_DTYPE}
_BLOCK = 10_000


class Mf4Writer(mf4.MF4Writer):
    """Takes messages like the other writers of python-can; the file is written at `stop`."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._first_s: float | None = None
        self._rows: list[list[tuple[float, can.Message]]] = [[] for _ in _GROUPS]

    def on_message_received(self, message: can.Message) -> None:
        """Append one message."""
        if self._first_s is None:
            self._first_s = float(int(message.timestamp))
            self._mdf.header.start_time = datetime.fromtimestamp(self._first_s, UTC)
        group = 2 if message.is_remote_frame else 1 if message.is_error_frame else 0
        self._rows[group].append((message.timestamp - self._first_s, message))
        if len(self._rows[group]) >= _BLOCK:
            self._flush(group)

    def stop(self) -> None:
        """Write the file."""
        for group in range(len(_GROUPS)):
            self._flush(group)
        super().stop()

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
    row[f"{name}.BusChannel"] = can.util.channel2int(message.channel) or 0
    row[f"{name}.ID"] = message.arbitration_id
    row[f"{name}.IDE"] = message.is_extended_id
    row[f"{name}.DLC"] = can.util.len2dlc(message.dlc)
    if message.is_remote_frame:
        return
    row[f"{name}.DataLength"] = len(message.data)
    row[f"{name}.DataBytes"][: len(message.data)] = message.data
    row[f"{name}.EDL"] = message.is_fd
    row[f"{name}.BRS"] = message.bitrate_switch
    row[f"{name}.ESI"] = message.error_state_indicator
