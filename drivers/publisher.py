"""The estimate on the bus, for a control to compensate with: Estimate and Compensation, by a bus handle of its own."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import can
import cantools
import numpy as np

from drivers.checks import frame_checksum
from drivers.dbc import find_dbc
from drivers.received import Received
from estimator.errors import BallscrewError, SetupError
from estimator.rig import Rig
from estimator.step import Mode, Step, Trust

ESTIMATE, COMPENSATION = "Estimate", "Compensation"
NO_SIGMA = 65535  # raw
COUNTS = 15
SPACING_S = 0.05  # rig time, between two pairs of frames of the same validity
RETRY_S = 5.0
REMEMBERED = 64  # frames of our own that may still come back


class Publisher:
    """Sends the two messages, and nothing else. `trouble` says in one sentence why it does not; `sent` counts frames.

    It stops for good when one of its ids comes from somebody else: two senders of one id are a fault of the bus.
    """

    def __init__(self, rig: Rig, opens: Callable[[], can.BusABC]) -> None:
        self.trouble, self.sent = "", 0
        path = find_dbc(rig.log.dbc or "", rig.folder)
        database: Any = cantools.database.load_file(path)
        known = {message.name: message for message in database.messages}
        if missing := [name for name in (ESTIMATE, COMPENSATION) if name not in known]:
            raise SetupError(f"--publish: {path} has no message '{missing[0]}'")
        self._messages = [known[ESTIMATE], known[COMPENSATION]]
        self._ids = {(message.frame_id, bool(message.is_extended_frame)) for message in self._messages}
        self._heat = np.isin(rig.names, rig.thermometers)
        self._opens, self._bus, self._count = opens, None, 0
        self._own: deque[bytes] = deque(maxlen=REMEMBERED)
        self._last, self._retry, self._stopped = (-np.inf, False), 0.0, False

    def send(self, now_s: float, step: Step, trust: Trust, position_mm: float) -> None:
        """Both frames of a moment; a bus that fails is tried again later."""
        if self._stopped or (abs(now_s - self._last[0]) < SPACING_S and trust.valid == self._last[1]):
            return
        bus = self._bus or self._open()
        if bus is None:
            return
        self._last = (now_s, trust.valid)
        try:
            for frame in self.frames(step, trust, position_mm):
                self._own.append(bytes(frame.data))
                bus.send(frame, timeout=0.1)
                self.sent += 1
        except Exception as error:  # each interface has its own
            self._lost(f"{type(error).__name__}: {error}")

    def frames(self, step: Step, trust: Trust, position_mm: float) -> list[can.Message]:
        """The two frames of a moment, counter and checksum included."""
        mode = step.mode if trust.valid or step.mode == Mode.INIT else Mode.INVALID
        sigma = step.sigma_um if np.isfinite(step.sigma_um) else np.inf
        estimate = {
            "EstCrc": 0, "EstCounter": self._count, "EstMode": int(mode), "EstElongation": _int24(step.elongation_um),
            "EstSigma": int(min(round(1e3 * sigma), NO_SIGMA - 1)) if np.isfinite(sigma) else NO_SIGMA,
            "EstChannels": int(min(step.fused[self._heat].sum(), 31)), "EstDisplacementStale": trust.displacement_stale,
            "EstTelemeterStale": trust.telemeter_stale, "EstDiverged": trust.diverged,
        }  # fmt: skip
        known = bool(np.isfinite(step.error_at_table_um) and np.isfinite(position_mm))
        compensation = {
            "CmpCrc": 0, "CmpCounter": self._count, "CmpValid": trust.valid and known,
            "CmpError": _int24(step.error_at_table_um), "CmpPosition": _int24(position_mm, 1e4),
        }  # fmt: skip
        self._count = (self._count + 1) % COUNTS
        return [_frame(m, values) for m, values in zip(self._messages, (estimate, compensation), strict=True)]

    def heard(self, frame: Received) -> None:
        """A frame has come on the bus: is it somebody else's with an id of ours?"""
        ours = (frame.id, frame.extended) in self._ids and frame.kind == "data"
        if ours and frame.data not in self._own and not self._stopped:
            self._stopped = True
            self.trouble = f"not publishing any more: 0x{frame.id:X} comes from another sender"
            self.close()

    def close(self) -> None:
        """Close the bus."""
        if self._bus is not None:
            with suppress(Exception):  # a bus that is gone cannot be closed either
                self._bus.shutdown()
        self._bus = None

    def _open(self) -> can.BusABC | None:
        if time.monotonic() < self._retry:
            return None
        try:
            self._bus = self._opens()
            self.trouble = ""
        except BallscrewError:
            raise
        except Exception as error:  # each interface has its own
            self._lost(f"{type(error).__name__}: {error}")
        return self._bus

    def _lost(self, why: str) -> None:
        self.trouble = f"not publishing: {' '.join(why.split())}"
        self._retry = time.monotonic() + RETRY_S
        self.close()


def _int24(value: float, scale: float = 1e3) -> int:
    """A signed 24-bit number, at its end where the value is beyond; 0 where it is not known."""
    return int(np.clip(round(scale * value), -(1 << 23), (1 << 23) - 1)) if np.isfinite(value) else 0


def _frame(message: Any, values: dict[str, Any]) -> can.Message:
    """Raw values into a frame, its checksum set."""
    data = bytearray(message.encode({k: int(v) for k, v in values.items()}, scaling=False, strict=False))
    data[0] = int(frame_checksum(message.frame_id, np.array([data], np.uint8))[0])
    return can.Message(arbitration_id=message.frame_id, data=data, is_extended_id=message.is_extended_frame)
