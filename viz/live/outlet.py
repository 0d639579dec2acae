"""One stream of a live view, fed from a thread of its own: whoever shows a tick never waits for a disk or a viewer."""

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import rerun as rr

from estimator.record import Sample
from estimator.step import Step
from viz.drawing.series import Event
from viz.lanes.standing import Judged, Standing
from viz.live.rows import Rows

WAITING = 20_000  # ticks and events that may wait; the oldest are given up
FLUSH_S, CLOSE_S = 2.0, 10.0


@dataclass
class Batch:
    """What has come since the last batch was sent."""

    ticks: deque[tuple[Sample, Step]] = field(default_factory=lambda: deque(maxlen=WAITING))
    events: deque[Event | Judged] = field(default_factory=lambda: deque(maxlen=WAITING))
    standing: Standing | None = None


class Outlet:
    """Gathers ticks and sends them every `every_s` seconds of wall time.

    What does not get out waits: a viewer that hangs holds up the whole server until it goes on or is gone.

    obstacle  says why nothing can be sent now, "" if it can
    """

    def __init__(
        self, name: str, rec: rr.RecordingStream, rows: Rows, every_s: float, obstacle: Callable[[], str] = lambda: ""
    ) -> None:
        self._name, self._rec, self._rows, self._every_s, self._obstacle = name, rec, rows, every_s, obstacle
        self._batch, self._waits = Batch(), ""
        self._lost, self._failed, self._error = 0, 0, ""
        self._turn = threading.Condition()
        self._left = False
        self._asked, self._answered, self._ended = 0, 0, False  # how often to send now, and how often that was done
        self._thread = threading.Thread(target=self._run, name=f"live views: {name}", daemon=True)
        self._thread.start()

    @property
    def trouble(self) -> str:
        """One line on what did not get out, "" while all is well; it changes only where there is something new."""
        waits = f"nothing gets out, ticks wait ({self._waits})" if self._waits else ""
        lost = f"{_roughly(self._lost)} ticks were given up" if self._lost else ""
        failed = f"{_roughly(self._failed)} batches failed, the last one: {self._error}" if self._failed else ""
        said = [each for each in (waits, lost, failed) if each]
        return f"{self._name}: {'; '.join(said)}" if said else ""

    def tick(self, sample: Sample, step: Step) -> None:
        """Take a tick."""
        with self._turn:
            self._lost += len(self._batch.ticks) == WAITING
            self._batch.ticks.append((sample, step))

    def event(self, event: Event | Judged) -> None:
        """Take what happened."""
        with self._turn:
            self._batch.events.append(event)

    def stand(self, standing: Standing) -> None:
        """Take how things stand; only the last one before a batch is sent counts."""
        with self._turn:
            self._batch.standing = standing

    def flush(self) -> None:
        """Send what waits, and wait a moment for it."""
        with self._turn:
            self._asked += 1
            mine = self._asked
            self._turn.notify_all()
            self._turn.wait_for(lambda: self._answered >= mine or self._ended, FLUSH_S)

    def leave(self) -> None:
        """Send what waits and no more, without waiting for it; the stream stays open."""
        with self._turn:
            self._ended = self._left = True
            self._turn.notify_all()

    def close(self) -> None:
        """Send what waits and end the stream, footer written; give it up if that takes too long."""
        with self._turn:
            self._ended = True
            self._turn.notify_all()
        self._thread.join(CLOSE_S)
        if self._thread.is_alive():
            self._waits = self._waits or "the stream does not end"
            rr.unregister_shutdown()  # it would wait for the stream for ever when the program ends

    def _run(self) -> None:
        ended = False
        while not ended:
            with self._turn:
                self._turn.wait_for(lambda: self._ended or self._asked > self._answered, self._every_s)
                ended, asked = self._ended, self._asked
            self._send()
            with self._turn:
                self._answered = asked
                self._turn.notify_all()
        self._guarded(self._rows.end)
        if not self._left:
            self._rec.disconnect()

    def _send(self) -> None:
        self._waits = self._obstacle() or (self._waits and self._held_up())
        if self._waits:
            return
        with self._turn:
            batch, self._batch = self._batch, Batch()
        if batch.ticks or batch.events or batch.standing is not None:
            self._guarded(lambda: self._rows.send(batch.ticks, batch.events, batch.standing))
            self._waits = self._held_up()

    def _held_up(self) -> str:
        """Why what was sent has not got out, "" if it has."""
        try:
            self._rec.flush(timeout_sec=FLUSH_S)
        except RuntimeError as error:
            return str(error)
        return ""

    def _guarded(self, send: Callable[[], None]) -> None:
        try:
            send()
        except Exception as error:  # whatever is wrong with a view, the monitor goes on and `trouble` tells
            self._failed, self._error = self._failed + 1, f"{type(error).__name__}: {error}"


def _roughly(count: int) -> str:
    """A number that grows in steps: 1, 2, 5 or more, 10 or more."""
    power = 10 ** (len(str(count)) - 1)
    round_one = max(m * power for m in (1, 2, 5) if m * power <= count)
    return str(count) if count < 3 else f"{round_one} or more"
