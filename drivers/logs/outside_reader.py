"""The process in which python-can reads: `python -m drivers.logs.outside_reader PATH MEMORY`; frames to stdout."""

from __future__ import annotations

import io
import json
import os
import sys
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from importlib import import_module
from typing import Any

from drivers.frames import PACKED
from drivers.logs.outside import HEAD

_READERS = {
    ".asc": "can.io.asc:ASCReader",
    ".blf": "can.io.blf:BLFReader",
    ".csv": "can.io.csv:CSVReader",
    ".trc": "can.io.trc:TRCReader",
    ".mf4": "can.io.mf4:MF4Reader",
}
_LONGEST_LINE = 4096


class WholeLines:
    """A text file line by line, for python-can's readers: a last line without its end is kept from them."""

    def __init__(self, path: str) -> None:
        self.file = open(path, "rb")  # noqa: SIM115  (the reader closes it)
        self.count = 0
        self.silent = 0  # lines since the last frame, comments left out
        self.torn = False

    def __iter__(self) -> Iterator[str]:
        return self

    def __next__(self) -> str:
        line = self.file.readline(_LONGEST_LINE)
        if not line:
            raise StopIteration
        self.count += 1
        if not line.endswith(b"\n"):
            self.torn = True
            raise StopIteration
        text = line.decode("utf-8", "surrogateescape") if line.isascii() else line.decode("latin-1")
        self.silent += not text.lstrip().startswith((";", "//", "End T", "end t")) and bool(text.strip())
        return text

    def read(self) -> str:
        """Only its presence counts: python-can takes what can be read for a file."""
        raise io.UnsupportedOperation("read")

    def tell(self) -> int:
        return self.file.tell()

    def close(self) -> None:
        self.file.close()


class Sender:
    """Packs frames into blocks, counts what is none of ours, and tells both."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.size = max(os.path.getsize(path), 1)
        self.skipped: Counter[str] = Counter()
        self.notes: list[str] = []
        self.messages = 0
        self.rows = bytearray()
        self.lines: WholeLines | None = None
        self.share = 0.0
        self.lock = threading.Lock()
        self.done = threading.Event()

    def run(self, suffix: str) -> None:
        """Read to the end, or to where the reader gives up."""
        try:
            self._read(suffix, {"relative_timestamp": False})
        except MemoryError:
            self.notes.append(f"stopped after {self.messages} frames: out of memory")
        except Exception as error:  # whatever python-can raises on a broken file, what came before counts
            if suffix == ".asc" and not self.messages and "datetime" in str(error):
                self._read(suffix, {})
            else:
                self._gave_up(error)
        self.done.set()
        self._torn()
        self.flush()
        found = f"{self.lines.count} lines read" if self.lines else f"{self.size} bytes"
        self.send(b"A", json.dumps({"skipped": self.skipped, "notes": self.notes, "found": found}).encode())

    def _read(self, suffix: str, options: dict[str, Any]) -> None:
        module, name = _READERS[suffix].split(":")
        source: Any = self.path
        if suffix in {".asc", ".trc", ".csv"}:
            source = self.lines = WholeLines(self.path)
        reader = getattr(import_module(module), name)(source, **options)
        threading.Thread(
            target=self._flush_now_and_then, args=(source if self.lines else reader.file,), daemon=True
        ).start()
        for message in reader:
            self.messages += 1
            self._take(message)
        if self.lines:
            self.skipped["line without a frame"] += self.lines.silent

    def _take(self, message: Any) -> None:
        if self.lines:
            # what stands before the first frame is the file's head
            self.skipped["line without a frame"] += max(self.lines.silent - 1, 0) if self.messages > 1 else 0
            self.lines.silent = 0
        if reason := _unusable(message):
            self.skipped[reason] += 1
            return
        place = self.lines.count if self.lines else self.messages
        data = bytes(message.data)
        row = PACKED.pack(
            message.timestamp, message.arbitration_id, message.is_extended_id, len(data), data, place & 0xFFFFFFFF
        )
        with self.lock:
            self.rows += row

    def _gave_up(self, error: Exception) -> None:
        place = f"line {self.lines.count}" if self.lines else f"frame {self.messages + 1}"
        text = " ".join(str(error).split())[:120]
        self.notes.append(f"torn at {place}: {type(error).__name__}{': ' * bool(text)}{text}; read up to there")

    def _torn(self) -> None:
        if self.lines and self.lines.torn:
            self.skipped["torn line"] += 1
            self.notes.append(f"torn at line {self.lines.count}: it has no line end; read up to there")
        if self.path.lower().endswith(".blf"):
            with open(self.path, "rb") as file:
                head = file.read(24)
            told = int.from_bytes(head[16:24], "little")
            if head[:4] == b"LOGG" and told != self.size:
                self.notes.append(f"torn: its head says {told} bytes, {self.size} are there; read up to there")

    def _flush_now_and_then(self, file: Any) -> None:
        # from a thread, so that the frames before a loop in the reader are not lost
        while not self.done.wait(0.1):
            with suppress(ValueError):  # the reader closed its file
                self.share = file.tell() / self.size
            self.flush()

    def flush(self) -> None:
        """Send the frames so far."""
        with self.lock:
            if self.rows:
                self.send(b"F", bytes(self.rows))
                self.rows.clear()

    def send(self, kind: bytes, body: bytes) -> None:
        """One block to the parent."""
        sys.stdout.buffer.write(HEAD.pack(kind, len(body), self.share) + body)
        sys.stdout.buffer.flush()


def _unusable(message: Any) -> str:
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
    Sender(path).run(os.path.splitext(path)[1].lower())


if __name__ == "__main__":
    main(*sys.argv[1:])
