"""--interface, --channel, --bitrate and --bus-kwargs: python-can's own words for a bus."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click


def bus_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options, the same on every command that opens a bus."""
    options = (
        click.option("--interface", help="python-can interface: socketcan, pcan, vector, slcan, socketcand ..."),
        click.option("--channel", help="Channel of the interface, like can0."),
        click.option("--bitrate", type=int, help="Bit rate of the bus, 1/s."),
        click.option(
            "--bus-kwargs", multiple=True, metavar="K=V ...", help="Passed to the interface, like host=127.0.0.1."
        ),
    )
    for option in reversed(options):
        command = option(command)
    return command
