"""Processes that tests start, and how long tests wait for what happens in other processes and threads."""

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

PATIENCE_S = 300.0  # no figure of ours: far longer than anything takes, on a machine with much else to do


def until(holds: Callable[[], object], what: str = "it never happened") -> None:
    """Wait for another thread or process."""
    end = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end, what
        time.sleep(0.01)


@contextmanager
def started(*words: object, **options: Any) -> Iterator[subprocess.Popen[str]]:
    """A process until the block ends, which Ctrl-C reaches; `ballscrew` is the command.

    A shell that starts the tests in the background has SIGINT ignored, and whoever is started inherits that.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        process = subprocess.Popen(command(*words), text=True, **options)
    finally:
        signal.signal(signal.SIGINT, before)
    with process:  # closes its pipes
        try:
            yield process
        finally:
            process.kill()


def ended(*words: object, **options: Any) -> subprocess.CompletedProcess[str]:
    """A process that ends by itself, with what it wrote."""
    return subprocess.run(command(*words), capture_output=True, text=True, timeout=PATIENCE_S, **options)


def command(*words: object) -> list[str]:
    """Words of a command line, in this very Python."""
    first, *rest = map(str, words)
    return [sys.executable, *(["-m", first] if first == "ballscrew" else [first]), *rest]
