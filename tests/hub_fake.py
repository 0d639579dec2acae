"""A hub for the length of a test."""

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from drivers.bus.hub import Hub


@contextmanager
def hub_running(hub: Hub | None = None, port: int = 0) -> Iterator[int]:
    """A hub on the loopback in a thread of this process; yields its port."""
    hub = hub or Hub()
    loop = asyncio.new_event_loop()
    try:
        opened = loop.run_until_complete(hub.open(port=port))
        thread = threading.Thread(target=loop.run_forever, name="hub")
        thread.start()
        try:
            yield opened
        finally:
            asyncio.run_coroutine_threadsafe(hub.close(), loop).result()
            loop.call_soon_threadsafe(loop.stop)
            thread.join()
    finally:
        loop.close()
