"""The process in which python-can reads: `python -m drivers.logs.outside_reader PATH HOW MEMORY`; frames to stdout."""

import json
import marshal
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

if __name__ == "__main__" and sys.argv[1].lower().endswith(".mf4"):
    import asammdf  # noqa: F401 before python-can, which would do without it

from drivers.canbus import can
from drivers.frames import PACKED, Tally
from drivers.logs.outside import EVERY, HEAD
from drivers.logs.python_can import Messages
from drivers.received import received_of


class Sender:
    """Packs frames into blocks, counts what is none of ours, and tells both."""

    def __init__(self, path: Path, how: str) -> None:
        self.tally = Tally()
        self.messages = Messages(path, self.tally)
        self.size = max(path.stat().st_size, 1)
        self.how = how
        self.buses: dict[str, int] = {}
        self.numbers: dict[Any, int] = {}  # of the buses, by what python-can calls their channels
        self.rows: list[Any] = []  # packed frames, or tuples
        self.lock = threading.Lock()
        self.done = threading.Event()

    def run(self) -> None:
        """Read to the end, or to where the reader gives up."""
        self._flush()  # it has started: from now on it is the file that holds it up
        threading.Thread(target=self._flush_now_and_then, daemon=True).start()
        take = self._every if self.how == EVERY else self._classic
        for message in self.messages:
            take(message)
        self.done.set()
        self._flush()
        about = {"found": self.messages.found, "buses": list(self.buses)}
        account = {"skipped": self.tally.skipped, "notes": self.tally.notes, **about}
        with self.lock:
            self._send(b"A", 0, json.dumps(account).encode())

    def _classic(self, message: can.Message) -> None:
        if reason := _unusable(message):
            self.tally.skip(reason)
            return
        if (bus := self.numbers.get(message.channel)) is None:
            bus = min(self.buses.setdefault(self.messages.channel(message), len(self.buses)), 255)
            self.numbers[message.channel] = bus
        about, data, place = (message.timestamp, message.arbitration_id), message.data, self.messages.place & 0xFFFFFFFF
        self._keep(PACKED.pack(*about, message.is_extended_id, len(data), data, place, bus))

    def _every(self, message: can.Message) -> None:
        if message.is_remote_frame or len(message.data) == message.dlc:
            self._keep(tuple(received_of(message, message.timestamp, self.messages.channel(message))))
        else:
            self.tally.skip("shortened frame")

    def _keep(self, row: Any) -> None:
        with self.lock:
            self.rows.append(row)

    def _flush_now_and_then(self) -> None:
        # from a thread, so that the frames before a loop in the reader are not lost, and its time is known
        while not self.done.wait(0.1):
            self._flush()

    def _flush(self) -> None:
        """Send the frames so far; if there are none, that it is still at it."""
        with self.lock:
            self._send(b"F", len(self.rows), marshal.dumps(self.rows) if self.how == EVERY else b"".join(self.rows))
            self.rows.clear()

    def _send(self, kind: bytes, frames: int, body: bytes) -> None:
        """One block to the parent."""
        share = self.messages.tell() / self.size
        sys.stdout.buffer.write(HEAD.pack(kind, frames, len(body), share, time.process_time()) + body)
        sys.stdout.buffer.flush()


def _unusable(message: can.Message) -> str:
    if message.is_error_frame:
        return "error frame"
    if message.is_remote_frame:
        return "remote frame"
    if message.is_fd:
        return "CAN FD frame"
    if message.data is None or len(message.data) != message.dlc or message.dlc > 8:
        return "shortened frame"
    return "" if 0 <= message.arbitration_id <= 0x1FFFFFFF else "impossible id"


def _limit(memory: int) -> None:
    # a system without such a limit still has those of time and frames
    with suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))


def main(path: str, how: str, memory: str) -> None:
    """Read one log."""
    _limit(int(memory))
    Sender(Path(path), how).run()


if __name__ == "__main__":
    main(*sys.argv[1:])
