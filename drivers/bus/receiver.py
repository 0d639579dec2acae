"""Frames off a bus, in a thread of its own that nothing ends but `stop`.

Whatever an interface raises means that the bus is lost: it is opened again, after 0.2 s, then twice as long up to 5 s.
Some interfaces say nothing when their daemon is gone: after 5 s without a frame the bus is opened anew as well, and
then after twice as long up to a minute, for it may only be silent.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from typing import NamedTuple

import can

from drivers.bus.bus import Listener, hang_up
from drivers.bus.rig_time import RigTime
from drivers.received import Received, received_of
from estimator.errors import BallscrewError

WAIT_S = 0.2
BACK_OFF_S = (0.2, 5.0)
SILENT_S = (5.0, 60.0)
AT_ONCE = 100
MOST_WAITING = 500_000  # frames that may wait for the estimate: a minute of a full bus
JOIN_S = 1.0
BUS_OFF = 0x40  # class bit of an error frame
TOLD_S = 10.0  # between two sentences about error frames


class Notice(NamedTuple):
    """A sentence about the bus itself; level is INFO or WARN."""

    text: str
    level: str = "WARN"


class Receiver:
    """Receives in the background; `record` is called there with every frame, before anything else.

    frames   taken so far, of all kinds;  errors  error frames among them
    waited_s how long the last frame taken had waited
    dropped  that were recorded but are not estimated from, because the estimate is too slow
    state    "opening", "open", "silent" or "lost"
    """

    def __init__(self, opens: Callable[[], Listener], clock: RigTime, record: Callable[[Received], None],
                 channel: str = "can0") -> None:  # fmt: skip
        self.clock, self.state = clock, "opening"
        self.frames = self.errors = self.dropped = 0
        self.failure: BallscrewError | None = None
        self._opens, self._record, self._channel = opens, record, channel
        self.waited_s = 0.0
        self._queue: queue.SimpleQueue[tuple[float, Received | Notice]] = queue.SimpleQueue()
        self._halt = threading.Event()
        self._gone_at: float | None = None
        self._silence = SILENT_S[0]
        self._error_told, self._opened_before = {False: -TOLD_S, True: -TOLD_S}, False
        self._thread = threading.Thread(target=self._run, name="receiver", daemon=True)

    def start(self) -> None:
        """Begin to listen."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread and close the bus."""
        asked = self._halt.is_set()
        self._halt.set()
        if self._thread.is_alive() and not asked:
            self._thread.join(JOIN_S)  # an interface may hang while it opens
        if not self._thread.is_alive():
            self._pass_on(self.clock.flush())

    def take(self, wait_s: float) -> list[Received | Notice]:
        """What has come since the last call; waits for the first at most so long."""
        items: list[Received | Notice] = []
        try:
            came, item = self._queue.get(timeout=wait_s)
            items.append(item)
            while len(items) < AT_ONCE:
                came, item = self._queue.get_nowait()
                items.append(item)
        except queue.Empty:
            pass
        self.waited_s = time.monotonic() - came if items else 0.0
        return items

    def _run(self) -> None:
        delay = BACK_OFF_S[0]
        while not self._halt.is_set():
            bus = None
            try:
                bus = self._opens()
                self._opened()
                delay = BACK_OFF_S[0]
                self._listen(bus)
            except BallscrewError as error:  # no such interface: it will never open
                self.failure = error
                return
            except Exception as error:  # each interface has its own
                self._lost(f"{type(error).__name__}: {error}")
                self._halt.wait(delay)
                delay = min(2 * delay, BACK_OFF_S[1])
            finally:
                hang_up(bus)

    def _listen(self, bus: Listener) -> None:
        """Take frames until the bus has been silent for too long."""
        last = time.monotonic()
        while not self._halt.is_set():
            message = bus.recv(WAIT_S)
            if message is None:
                if time.monotonic() - last > self._silence:
                    self._silent(time.monotonic() - last)
                    return
                self._pass_on(self.clock.overdue())
                continue
            last = time.monotonic()
            self._back()
            self._take(message)

    def _take(self, message: can.Message) -> None:
        frame = received_of(message, message.timestamp or time.time(), self._channel)
        self.frames += 1
        if frame.kind == "error":
            self._error(frame)
        self._pass_on(self.clock.place(frame))

    def _pass_on(self, frames: list[Received]) -> None:
        for frame in frames:
            self._record(frame)
            if frame.kind == "error":
                continue
            if self._queue.qsize() < MOST_WAITING:
                self._put(frame)
            else:
                self.dropped += 1

    def _put(self, item: Received | Notice) -> None:
        self._queue.put((time.monotonic(), item))

    def _error(self, frame: Received) -> None:
        self.errors += 1
        off = bool(frame.id & BUS_OFF)
        if time.monotonic() - self._error_told[off] > TOLD_S:
            self._error_told[off] = time.monotonic()
            what = "bus off: the controller has left the bus" if off else f"error frame, {self.errors} so far"
            self._put(Notice(f"{what} (class 0x{frame.id:X}, {frame.data.hex().upper()})"))

    def _opened(self) -> None:
        if self.state == "opening":
            self.state = "open"
        if not self._opened_before:
            self._opened_before = True
            self._put(Notice(f"listening on {self._channel}", "INFO"))

    def _lost(self, why: str) -> None:
        if self.state != "lost":
            self._put(Notice(f"bus lost: {' '.join(why.split())}; trying to open it again"))
            self._gone()
        self.state = "lost"

    def _silent(self, seconds: float) -> None:
        if self.state != "silent":
            self._put(Notice(f"no frame for {seconds:.1f} s: opening the bus anew"))
            self._gone(seconds)
        self.state = "silent"
        self._silence = min(2 * self._silence, SILENT_S[1])

    def _gone(self, already_s: float = 0.0) -> None:
        if self._gone_at is None:
            self._gone_at = time.monotonic() - already_s

    def _back(self) -> None:
        """A frame has come."""
        self._silence = SILENT_S[0]
        if self._gone_at is not None:
            self._put(Notice(f"frames again after {time.monotonic() - self._gone_at:.1f} s", "INFO"))
            self._gone_at = None
        self.state = "open"
