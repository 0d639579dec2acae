"""Code of a user's own that never ends ends the command; Ctrl-C stays Ctrl-C."""

from __future__ import annotations

import _thread

import pytest

from ballscrew.own_effect.patience import patience
from estimator.errors import SetupError


def loops(seconds: float = 60.0, interrupt: bool = False) -> None:
    with patience("own.py", seconds):
        if interrupt:
            _thread.interrupt_main()
        while True:
            pass


def test_what_never_ends_is_named():
    with pytest.raises(SetupError, match=r"^own.py: an effect's own code has not ended after 0.1 s; does it loop\?$"):
        loops(0.1)


def test_what_ends_goes_on():
    with patience("own.py"):
        done = 1 + 1
    assert done == 2


def test_ctrl_c_is_not_taken_for_it():
    with pytest.raises(KeyboardInterrupt):
        loops(interrupt=True)
