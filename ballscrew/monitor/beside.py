"""Work beside the monitor: writing for a reader who may stall, as a pipe, a disk or a lost terminal does."""

from collections.abc import Callable
from contextlib import suppress
from queue import Full, Queue
from threading import Thread

END_S = 1.0  # that the last jobs have at the end


class Beside:
    """Jobs done one after the other by a thread of their own; while `room` of them wait, new ones are lost."""

    def __init__(self, room: int) -> None:
        self._waiting = Queue[Callable[[], object] | None](room)
        self._thread = Thread(target=self._work, daemon=True)
        self._thread.start()

    def __call__(self, job: Callable[[], object]) -> bool:
        """Have a job done; whether there was room for it."""
        try:
            self._waiting.put_nowait(job)
        except Full:
            return False
        return True

    @property
    def full(self) -> bool:
        """Whether the next job will be lost."""
        return self._waiting.full()

    @property
    def idle(self) -> bool:
        """Whether no job waits."""
        return self._waiting.empty()

    def close(self) -> bool:
        """End after the jobs that wait, but not later than in two seconds; whether they were done."""
        with suppress(Full):
            self._waiting.put(None, timeout=END_S)
        self._thread.join(END_S)
        return not self._thread.is_alive()

    def _work(self) -> None:
        while (job := self._waiting.get()) is not None:
            job()
