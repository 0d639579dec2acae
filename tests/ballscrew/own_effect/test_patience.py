"""Code of a user's own that never ends ends the command; Ctrl-C stays what it was."""

import _thread
import signal
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

import pytest

from ballscrew.own_effect.patience import patience
from estimator.errors import SetupError

ENDED = r"^own.py: an effect's own code has not ended after 0.1 s; does it loop\?$"


@pytest.fixture(params=[signal.default_int_handler, signal.SIG_IGN], ids=["heard", "ignored"])
def ctrl_c(request) -> Iterator[object]:
    """What Ctrl-C does: a shell that starts a command in the background has it ignored."""
    before = signal.signal(signal.SIGINT, request.param)
    yield request.param
    signal.signal(signal.SIGINT, before)


def loops(seconds: float, interrupt: bool = False) -> None:
    with patience("own.py", seconds):
        if interrupt:
            _thread.interrupt_main()
        while True:
            with suppress(Exception):
                pass


def test_what_never_ends_is_named(ctrl_c):
    with pytest.raises(SetupError, match=ENDED):
        loops(0.1)
    assert signal.getsignal(signal.SIGINT) == ctrl_c


def test_it_is_named_in_any_thread():
    with ThreadPoolExecutor(1) as pool, pytest.raises(SetupError, match=ENDED):
        pool.submit(loops, 0.1).result()


def test_what_ends_goes_on(ctrl_c):
    with patience("own.py"):
        done = 1 + 1
    assert done == 2
    assert signal.getsignal(signal.SIGINT) == ctrl_c


@pytest.mark.parametrize("ctrl_c", [signal.default_int_handler], indirect=True)
def test_ctrl_c_is_not_taken_for_it(ctrl_c):
    with pytest.raises(KeyboardInterrupt):
        loops(60.0, interrupt=True)


@pytest.mark.parametrize("ctrl_c", [signal.SIG_IGN], indirect=True)
def test_a_ctrl_c_that_is_ignored_ends_nothing(ctrl_c):
    with pytest.raises(SetupError, match=ENDED):
        loops(0.1, interrupt=True)


def test_code_that_is_traced_later_ends():
    """As under a debugger, or where coverage is measured."""
    with patience("own.py"):
        pass
    events: list[str] = []
    sys.setprofile(lambda _frame, event, _argument: events.append(event))
    try:
        (lambda: None)()
    finally:
        sys.setprofile(None)
    assert 0 < len(events) < 50
