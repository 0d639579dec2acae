"""Frames off a bus, in a thread of its own that nothing ends but `stop`.

Whatever an interface raises means that the bus is lost: it is opened again, after 0.2 s, then twice as long up to 5 s.
Some interfaces say nothing when their daemon is gone: after 5 s without a frame the bus is opened anew as well, and
then after twice as long up to a minute, for it may only be silent. A bus that has never been open for ten seconds is a
mistake of whoever named it.
"""

import math
import queue
import threading
import time
from collections.abc import Callable, Sequence

from drivers.bus.age import Age
from drivers.bus.bus import Listener, hang_up, told
from drivers.bus.rig_time import RigTime
from drivers.received import Notice, Received, received_of
from estimator.errors import BallscrewError, InputError

WAIT_S = 0.2
BACK_OFF_S = (0.2, 5.0)
SILENT_S = (5.0, 60.0)
OPEN_S = 10.0  # for a hub or an interface that is only just being started
AT_ONCE = 100
MOST_WAITING = 500_000  # frames that may wait for the estimate: a minute of a full bus
JOIN_S = 1.0
BUS_OFF = 0x40  # class bit of an error frame
TOLD_S = 10.0  # between two sentences about the same


class Receiver:
    """Receives in the background; all who `hear` are told there of every frame, before anything else.

    frames   taken so far, of all kinds;  errors  error frames among them
    missed   that the kernel had no room for
    dropped  that were recorded but are not estimated from, because the estimate is too slow
    age_s    how old the last frame taken was: it may have waited in the buffers of the bus, and in ours
    state    "opening", "open", "silent" or "lost"
    """

    def __init__(self, opens: Callable[[], Listener], clock: RigTime, hear: Sequence[Callable[[Received], None]],
                 channel: str = "can0") -> None:  # fmt: skip
        self.clock, self.state = clock, "opening"
        self.frames = self.errors = self.missed = self.dropped = 0
        self.failure: BallscrewError | None = None
        self._opens, self._hear, self._channel = opens, hear, channel
        self.age_s = self._came_old_s = 0.0
        self._queue: queue.SimpleQueue[tuple[float, Received | Notice]] = queue.SimpleQueue()
        self._halt = threading.Event()
        self._gone_at: float | None = None
        self._silence = SILENT_S[0]
        self._told = dict[str, float]()
        self._began_s, self._opened_before, self._why = math.inf, False, "it does not answer"
        self._thread = threading.Thread(target=self._run, name="receiver", daemon=True)

    def start(self) -> None:
        """Begin to listen."""
        self._began_s = time.monotonic()
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
        self.age_s = time.monotonic() - came if items else 0.0
        self._give_up()
        return items

    @property
    def waiting(self) -> bool:
        """Whether something has come that was not taken yet."""
        return not self._queue.empty()

    def _give_up(self) -> None:
        if self.failure is None and not self._opened_before and time.monotonic() - self._began_s > OPEN_S:
            self.failure = InputError(f"{self._channel}: could not be opened for {OPEN_S:g} s: {self._why}")

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
                self._lost(told(error))
                self._halt.wait(delay)
                delay = min(2 * delay, BACK_OFF_S[1])
            finally:
                hang_up(bus)

    def _listen(self, bus: Listener) -> None:
        """Take frames until the bus has been silent for too long."""
        last, age, waited_for, missed = time.monotonic(), Age(), False, 0
        while not self._halt.is_set():
            message = bus.recv(WAIT_S)
            now = time.monotonic()
            if message is None:
                if now - last > self._silence:
                    self._silent(now - last)
                    return
                waited_for, self._came_old_s = True, 0.0
                self._pass_on(self.clock.overdue())
                continue
            last = now
            self._back()
            stamp = message.timestamp or time.time()
            self._came_old_s = age.of(stamp, now, waited_for)
            waited_for = False
            self._take(received_of(message, stamp, self._channel))
            self._miss(bus.lost() - missed)
            missed = bus.lost()

    def _take(self, frame: Received) -> None:
        self.frames += 1
        if frame.kind == "error":
            self._error(frame)
        self._pass_on(self.clock.place(frame))

    def _miss(self, frames: int) -> None:
        if frames:
            self.missed += frames
            self._tell_now_and_then("missed", f"{self.missed} frames lost so far: this machine reads too slowly")

    def _pass_on(self, frames: list[Received]) -> None:
        for frame in frames:
            for hear in self._hear:
                hear(frame)
            if frame.kind == "error":
                continue
            if self._queue.qsize() < MOST_WAITING:
                self._put(frame)
            else:
                self.dropped += 1

    def _put(self, item: Received | Notice) -> None:
        self._queue.put((time.monotonic() - self._came_old_s, item))

    def _error(self, frame: Received) -> None:
        self.errors += 1
        off = bool(frame.id & BUS_OFF)
        what = "bus off: the controller has left the bus" if off else f"error frame, {self.errors} so far"
        self._tell_now_and_then(f"error {off}", f"{what} (class 0x{frame.id:X}, {frame.data.hex().upper()})")

    def _tell_now_and_then(self, about: str, text: str) -> None:
        if time.monotonic() - self._told.get(about, -TOLD_S) >= TOLD_S:
            self._told[about] = time.monotonic()
            self._put(Notice(text))

    def _opened(self) -> None:
        if self.state == "opening":
            self.state = "open"
        if not self._opened_before:
            self._opened_before = True
            self._put(Notice(f"listening on {self._channel}", "INFO"))

    def _lost(self, why: str) -> None:
        self._why = why
        if self.state != "lost":
            what = "bus lost" if self._opened_before else "bus not open yet"
            self._put(Notice(f"{what}: {self._why}; trying to open it again"))
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
