"""The estimate on the bus, for a control to compensate with: Estimate and Compensation, by a bus handle of its own."""

import queue
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np

from drivers.bus.bus import hang_up, told
from drivers.canbus import can, cantools
from drivers.decode.checks import frame_checksum
from drivers.decode.dbc import find_dbc
from drivers.received import Received
from estimator.alarms.trust import Trust
from estimator.errors import SetupError
from estimator.rig import Rig
from estimator.step import Mode, Step

ESTIMATE, COMPENSATION = "Estimate", "Compensation"
NO_SIGMA = 65535  # raw
COUNTS = 15
SPACING_S = 0.008  # wall time between two pairs of frames of the same validity
STALE_S = 0.1  # a pair that could not be sent by then is not sent any more
RETRY_S = 5.0
JOIN_S = 0.5  # a bus that hangs does not hold up the end either
ECHO_S = 10.0  # a frame of our own may come back for so long
ENDED = Trust(("the monitor has ended",), True, True, False)

Job = tuple[float, list[can.Message]]


class Publisher:
    """Sends the two messages, and nothing else, in a thread of its own: a bus that hangs does not hold up the estimate.

    It stops for good when one of its ids comes from somebody else: two senders of one id are a fault of the bus.

    trouble  why it does not send, in one sentence;  sent  frames
    """

    def __init__(self, rig: Rig, opens: Callable[[], can.BusABC]) -> None:
        self.trouble, self.sent = "", 0
        path = find_dbc(rig.log.dbc, rig.folder)
        database: Any = cantools.database.load_file(path, strict=False)  # others may be broken
        known = {message.name: message for message in database.messages}
        if missing := [name for name in (ESTIMATE, COMPENSATION) if name not in known]:
            raise SetupError(f"--publish: {path} has no message '{missing[0]}'")
        self._messages = [known[ESTIMATE], known[COMPENSATION]]
        self._ids = {(message.frame_id, bool(message.is_extended_frame)) for message in self._messages}
        self._heat = rig.is_thermometer
        self._opens, self._count = opens, 0
        self._bus: can.BusABC | None = None
        self._own: dict[bytes, float] = {}
        self._last, self._retry, self._stopped = (-np.inf, False), -np.inf, False
        self._step: Step | None = None
        self._jobs: queue.SimpleQueue[Job] = queue.SimpleQueue()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="publisher", daemon=True)

    def start(self) -> None:
        """Begin to send what is to be sent."""
        self._thread.start()

    def send(self, step: Step, trust: Trust, position_mm: float) -> None:
        """Both frames of a moment, unless the same was said a moment ago."""
        now = time.monotonic()
        self._step = step
        if not self._stopped and (now - self._last[0] >= SPACING_S or trust.valid != self._last[1]):
            self._last = (now, trust.valid)
            self._jobs.put((now, self.frames(step, trust, position_mm)))

    def close(self) -> None:
        """Say that the estimate is not valid any more, and close the bus."""
        if self._step is not None:
            self.send(self._step, ENDED, float("nan"))
        self._over.set()
        if self._thread.is_alive():
            self._thread.join(JOIN_S)
        self._hang_up()

    def frames(self, step: Step, trust: Trust, position_mm: float) -> list[can.Message]:
        """The two frames of a moment, counter and checksum included."""
        told = np.isfinite(step.elongation_um) and np.isfinite(step.sigma_um)
        mode = step.mode if (trust.valid and told) or step.mode == Mode.INIT else Mode.INVALID
        sigma = step.sigma_um if told else np.inf
        estimate = {
            "EstCrc": 0, "EstCounter": self._count, "EstMode": int(mode), "EstElongation": _int24(step.elongation_um),
            "EstSigma": int(min(round(1e3 * sigma), NO_SIGMA - 1)) if np.isfinite(sigma) else NO_SIGMA,
            "EstChannels": int(min(step.fused[self._heat].sum(), 31)), "EstDisplacementStale": trust.displacement_stale,
            "EstTelemeterStale": trust.telemeter_stale, "EstDiverged": trust.diverged,
        }  # fmt: skip
        known = bool(np.isfinite(step.error_at_table_um) and np.isfinite(position_mm))
        compensation = {
            "CmpCrc": 0, "CmpCounter": self._count, "CmpValid": trust.valid and known,
            "CmpBeganWarm": trust.began_warm, "CmpError": _int24(step.error_at_table_um),
            "CmpPosition": _int24(position_mm, 1e4),
        }  # fmt: skip
        self._count = (self._count + 1) % COUNTS
        return [_frame(m, values) for m, values in zip(self._messages, (estimate, compensation), strict=True)]

    def heard(self, frame: Received) -> None:
        """A frame comes on the bus: is it somebody else's with an id of ours? Ask at once: echoes are forgotten."""
        if self._stopped or frame.kind != "data" or (frame.id, frame.extended) not in self._ids:
            return
        if frame.data not in self._own:
            self._stopped = True
            self.trouble = f"not publishing any more: 0x{frame.id:X} comes from another sender"

    def _run(self) -> None:
        while not (self._over.is_set() and self._jobs.empty()):
            self.turn(0.1)

    def turn(self, wait_s: float) -> None:
        """Send what there is to send; waits for it at most so long."""
        job: Job | None = None
        with suppress(queue.Empty):
            job = self._jobs.get(timeout=wait_s) if wait_s else self._jobs.get_nowait()
        try:
            self._drain()
            if job is not None and not self._stopped:
                self._transmit(*job)
        except Exception as error:  # each interface has its own
            self.trouble = f"not publishing: {told(error)}"
            self._retry = time.monotonic() + RETRY_S
            self._hang_up()

    def _drain(self) -> None:
        """Nobody reads this handle: what piles up there would be lost to us, and a burden to whoever holds it."""
        for _ in range(10_000):
            if self._bus is None or self._bus.recv(0) is None:
                return

    def _transmit(self, since: float, frames: list[can.Message]) -> None:
        now = time.monotonic()
        if self._bus is None and now >= self._retry:
            self._bus = self._opens()
            self.trouble = ""
            since = now  # opening took its time
        if self._bus is None or now - since > STALE_S:
            return
        self._own = {data: at for data, at in self._own.items() if now - at < ECHO_S}
        for frame in frames:
            self._own[bytes(frame.data)] = now
            self._bus.send(frame, timeout=0.1)
            self.sent += 1

    def _hang_up(self) -> None:
        hang_up(self._bus)
        self._bus = None


def _int24(value: float, scale: float = 1e3) -> int:
    """A signed 24-bit number, at its end where the value is beyond; 0 where it is not known."""
    return int(np.clip(round(scale * value), -(1 << 23), (1 << 23) - 1)) if np.isfinite(value) else 0


def _frame(message: Any, values: dict[str, Any]) -> can.Message:
    """Raw values into a frame, its checksum set."""
    data = bytearray(message.encode({k: int(v) for k, v in values.items()}, scaling=False, strict=False))
    data[0] = int(frame_checksum(message.frame_id, np.array([data], np.uint8))[0])
    return can.Message(arbitration_id=message.frame_id, data=data, is_extended_id=message.is_extended_frame)
