"""A run on a live bus, in the rig's time or faster."""

import time

import can

from drivers.virtual_rig.frames.frames import EPOCH_S, frame_table
from drivers.virtual_rig.run import Run


def play(run: Run, bus: can.BusABC, speed_up: float = 1.0) -> None:
    """Send every frame when it is due: t_start + t_rig / speed_up on the steady clock, so that delays never add up."""
    messages = frame_table(run).messages()
    start = time.monotonic()
    for message in messages:
        wait = start + (message.timestamp - EPOCH_S) / speed_up - time.monotonic()
        if wait > 0:
            time.sleep(wait)
        bus.send(message)
