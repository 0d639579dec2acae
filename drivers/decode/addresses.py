"""J1939: ids of one parameter group differ in priority and in the sender's address, another on each machine."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drivers.decode.dbc import Dbc, Layout
from drivers.frames import Frames, Tally, Whole, key_of
from estimator.errors import InputError


def group_of(ids: Whole) -> Whole:
    """The parameter group of 29-bit ids, (n,): without priority, sender's address and, in PDU 1, the receiver's."""
    to_all = (ids >> 16 & 0xFF) >= 240
    return ids & np.where(to_all, 0x03FFFF00, 0x03FF0000)


def addressed(frames: Frames, used: Sequence[Layout], dbc: Dbc, name: str, tally: Tally) -> Frames:
    """The frames, those of a group that the rig needs with the id that the DBC gives it.

    Only where that id never comes. Two senders of a group on one bus are an InputError.
    """
    there = set(np.unique(frames.key).tolist())
    if not any(message.extended and message.key not in there for message in used):
        return frames
    strangers = np.array(sorted(k for k in there - {*dbc.by_key} if k & 1), np.int64)
    ids = frames.id.copy()
    for message in used:
        if not message.extended or message.key in there:
            continue
        same = strangers[group_of(strangers >> 1) == group_of(np.array([message.id]))]
        for bus in set(frames.bus[np.isin(frames.key, same)].tolist()):
            on = frames.bus == bus
            senders = [int(key) >> 1 for key in same if (on & (frames.key == key)).any()]
            if len(senders) > 1:
                texts = " and ".join(f"0x{one:08X}" for one in senders[:3])
                raise InputError(
                    f"{name}: {message.name} (0x{message.id:08X}) comes from the source addresses of {texts}: "
                    f"write the id of the rig's into {dbc.path.name}"
                )
            ids[on & (frames.key == (senders[0] << 1 | 1))] = message.id
            tally.note(_said(message, senders[0], dbc))
    return replace(frames, id=ids)


def _said(message: Layout, can_id: int, dbc: Dbc) -> str:
    is_there = f"{dbc.path.name} has it as 0x{message.id:08X}, another source address or priority"
    return f"{message.name} is read from 0x{can_id:08X}: {is_there}"


class Addresses:
    """The same live, frame by frame: the first sender of a group counts as long as the id of the DBC has not come."""

    def __init__(self, used: Sequence[Layout], dbc: Dbc, tally: Tally) -> None:
        self.tally = tally
        self._dbc = dbc
        self._awaited = {_group(message.id): message for message in used if message.extended}
        self._taken: dict[int, int] = {}  # ids that were read as another, and as which

    def id_of(self, can_id: int, extended: bool) -> int:
        """The id that the DBC gives a frame's message."""
        if not extended or not self._awaited:
            return can_id
        if can_id in self._taken:
            return self._taken[can_id]
        message = self._awaited.get(_group(can_id))
        if message is None:
            return can_id
        if can_id == message.id:
            self._awaited.pop(_group(can_id))
            self._taken = {other: read for other, read in self._taken.items() if read != can_id}
        elif message.id not in self._taken.values() and key_of(can_id, True) not in self._dbc.by_key:
            self._taken[can_id] = message.id
            self.tally.note(_said(message, can_id, self._dbc))
        return self._taken.get(can_id, can_id)


def _group(can_id: int) -> int:
    return int(group_of(np.array([can_id]))[0])
