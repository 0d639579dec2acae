"""J1939: ids of one parameter group differ in priority and in the sender's address, another on each machine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drivers.decode.dbc import Dbc, Layout
from drivers.frames import Frames, Tally, Whole
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
            tally.note(
                f"{message.name} is read from 0x{senders[0]:08X}: {dbc.path.name} has it as 0x{message.id:08X}, "
                "another source address or priority"
            )
    return frames.with_ids(ids)
