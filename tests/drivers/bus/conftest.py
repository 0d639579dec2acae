"""A hub on a port that is free, and python-can's clients of it."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import can
import pytest

from drivers.bus.hub import Hub
from tests.hub_fake import hub_running


@pytest.fixture
def hub() -> Hub:
    return Hub()


@pytest.fixture
def port(hub: Hub) -> Iterator[int]:
    with hub_running(hub) as opened:
        yield opened


@pytest.fixture
def bus(port: int) -> Iterator[Callable[..., can.BusABC]]:
    """bus(channel): python-can's client."""
    with ExitStack() as stack:
        yield lambda channel="can0", port=port: stack.enter_context(
            can.Bus(interface="socketcand", channel=channel, host="127.0.0.1", port=port)
        )
