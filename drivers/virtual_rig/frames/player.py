"""Frames on a live bus, in the rig's time or faster."""

import time
from collections.abc import Iterable

import can


def play(messages: Iterable[can.Message], bus: can.BusABC, speed_up: float = 1.0) -> None:
    """Send frames when they are due, stamped from 0 s of the rig's time on: at t_start + t_rig / speed_up on the steady
    clock, so that delays never add up."""
    start = time.monotonic()
    for message in messages:
        wait = start + message.timestamp / speed_up - time.monotonic()
        if wait > 0:
            time.sleep(wait)
        bus.send(message)
