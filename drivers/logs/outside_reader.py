"""The process in which python-can reads: `python -m drivers.logs.outside_reader PATH MEMORY`; frames to stdout."""

from __future__ import annotations

import json
import sys
import threading
from contextlib import suppress
from pathlib import Path

import can

from drivers.frames import PACKED, Tally
from drivers.logs.outside import HEAD
from drivers.logs.python_can import Messages


class Sender:
    """Packs frames into blocks, counts what is none of ours, and tells both."""

    def __init__(self, path: Path) -> None:
        self.tally = Tally()
        self.messages = Messages(path, self.tally)
        self.size = max(path.stat().st_size, 1)
        self.rows = bytearray()
        self.lock = threading.Lock()
        self.done = threading.Event()

    def run(self) -> None:
        """Read to the end, or to where the reader gives up."""
        self._send(b"F", b"")  # it has started: from now on it is the file that holds it up
        threading.Thread(target=self._flush_now_and_then, daemon=True).start()
        for message in self.messages:
            self._take(message)
        self.done.set()
        self._flush()
        account = {"skipped": self.tally.skipped, "notes": self.tally.notes, "found": self.messages.found}
        self._send(b"A", json.dumps(account).encode())

    def _take(self, message: can.Message) -> None:
        if reason := _unusable(message):
            self.tally.skip(reason)
            return
        data, place = bytes(message.data), self.messages.place & 0xFFFFFFFF
        about = message.timestamp, message.arbitration_id, message.is_extended_id
        with self.lock:
            self.rows += PACKED.pack(*about, len(data), data, place)

    def _flush_now_and_then(self) -> None:
        # from a thread, so that the frames before a loop in the reader are not lost
        while not self.done.wait(0.1):
            self._flush()

    def _flush(self) -> None:
        """Send the frames so far."""
        with self.lock:
            if self.rows:
                self._send(b"F", bytes(self.rows))
                self.rows.clear()

    def _send(self, kind: bytes, body: bytes) -> None:
        """One block to the parent."""
        sys.stdout.buffer.write(HEAD.pack(kind, len(body), self.messages.tell() / self.size) + body)
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


def main(path: str, memory: str) -> None:
    """Read one log."""
    _limit(int(memory))
    Sender(Path(path)).run()


if __name__ == "__main__":
    main(*sys.argv[1:])
