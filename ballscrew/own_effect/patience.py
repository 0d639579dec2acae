"""A user's own code may never end: then the command does, and says so."""

import _thread
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from estimator.errors import SetupError

SECONDS = 60.0  # of wall time; what such a file imports may take a while


@contextmanager
def patience(whose: object, seconds: float = SECONDS) -> Iterator[None]:
    """Code of a user's own runs inside, in the main thread; where it has not ended by then it is a SetupError.

    Also where Ctrl-C is ignored, as in the background of a shell: there it goes on being ignored.
    """
    out = threading.Event()

    def lose() -> None:
        out.set()
        _thread.interrupt_main()

    def interrupted(*signalled: object) -> None:
        if out.is_set():
            raise KeyboardInterrupt  # which no `except Exception` in that code holds up
        if callable(before):
            before(*signalled)

    timer = threading.Timer(seconds, lose)
    timer.daemon = True
    before = signal.signal(signal.SIGINT, interrupted)
    timer.start()
    try:
        yield
    except KeyboardInterrupt:
        if not out.is_set():
            raise
        raise SetupError(f"{whose}: an effect's own code has not ended after {seconds:g} s; does it loop?") from None
    finally:
        timer.cancel()
        signal.signal(signal.SIGINT, before)
