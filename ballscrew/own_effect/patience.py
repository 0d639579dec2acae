"""A user's own code may never end: then the command does, and says so."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import c_ulong, py_object, pythonapi

from estimator.errors import SetupError

SECONDS = 60.0  # of wall time; what such a file imports may take a while


class _Over(BaseException):
    """No `except Exception` in that code holds it up, and nobody takes it for a Ctrl-C."""


@contextmanager
def patience(whose: object, seconds: float = SECONDS) -> Iterator[None]:
    """Code of a user's own runs inside; where it has not ended by then it is a SetupError.

    In any thread, as a worker has its jobs in one that is not the main one, which alone hears signals.
    """
    thread, over = c_ulong(threading.get_ident()), threading.Event()

    def end() -> None:
        over.set()
        pythonapi.PyThreadState_SetAsyncExc(thread, py_object(_Over))

    timer = threading.Timer(seconds, end)
    timer.daemon = True
    timer.start()
    try:
        try:
            yield
        finally:
            timer.cancel()
            timer.join()
            for _ in range(over.is_set()):  # what has just been begun is raised here; to take it back with a null
                pass  # would have every call from then on look for it, and a traced one never end (CPython 3.11)
    except _Over:
        raise SetupError(f"{whose}: an effect's own code has not ended after {seconds:g} s; does it loop?") from None
