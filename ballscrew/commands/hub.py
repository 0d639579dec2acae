"""ballscrew hub: a CAN bus between programs of one machine, without CAN hardware."""

import asyncio
import signal
from contextlib import suppress
from ipaddress import ip_address

import click

from ballscrew.options import terminal_options
from ballscrew.terminal import Terminal
from drivers.bus.hub import Hub


@click.command("hub")
@click.option(
    "--port", type=click.IntRange(0, 65535), default=28600, show_default=True, help="TCP port; 0 is any free one."
)
@click.option(
    "--bind", default="127.0.0.1", show_default=True, help="Address to listen on; this one is for this machine only."
)
@terminal_options
def command(terminal: Terminal, port: int, bind: str) -> None:
    """Share a CAN bus between programs of this machine, without CAN hardware, until Ctrl-C.

    Every frame that one program sends on a channel goes to all others on it. The hub speaks the socketcand protocol:
    python-can's interface `socketcand` connects to it, and so does `ballscrew simulate`. It carries classic data
    frames; a program that reads too slowly loses frames, which is said here.
    """
    if not _is_loopback(bind):
        terminal.warn(f"--bind {bind}: whoever reaches this address can read and send frames, without a password")
    hub = Hub(lambda sentence: terminal.warn(f"hub: {sentence}"))
    try:
        asyncio.run(_serve(terminal, hub, bind, port))
    finally:
        terminal.json({"frames": hub.frames, "dropped": hub.dropped})


async def _serve(terminal: Terminal, hub: Hub, bind: str, port: int) -> None:
    """Until SIGTERM; Ctrl-C comes as an exception."""
    over = asyncio.Event()
    with suppress(NotImplementedError):  # Windows has no such signal
        asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, over.set)
    opened = await hub.open(bind, port)
    where = f"--interface socketcand --channel can0 --bus-kwargs host={bind} port={opened}"
    terminal.say(f"hub: socketcand on {bind}:{opened}")
    terminal.say(f"  ballscrew simulate FS-20 {where}")
    terminal.say(f"  ballscrew live {where}")
    try:
        await over.wait()
    finally:
        await hub.close()
        terminal.say(f"hub: ended after {hub.frames} frames, {hub.dropped} dropped for slow programs")


def _is_loopback(bind: str) -> bool:
    try:
        return bind == "localhost" or ip_address(bind).is_loopback
    except ValueError:
        return False
