"""Logs as python-can reads them: every message in order, and what was none."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from drivers.canbus import can
from drivers.frames import Tally
from drivers.logs.lines import AscLines, WholeLines

_DATED_S = 1e6  # later stamps count from 1970
TEXT = frozenset({".asc", ".csv", ".trc"})


class Messages:
    """The messages of one log; whatever python-can raises on a broken file, those before it count.

    count   messages so far
    """

    def __init__(self, path: Path, tally: Tally) -> None:
        self.count = 0
        self._path, self._tally = path, tally
        self._suffix, self._size = path.suffix.lower(), path.stat().st_size
        self._lines: WholeLines | None = None
        self._file: Any = None
        self._byte = 0

    @property
    def place(self) -> int:
        """Where the latest message stands: its line in a text log, else its number."""
        return self._lines.count if self._lines else self.count

    @property
    def found(self) -> str:
        """What was read, in words."""
        return f"{self._lines.count} lines read" if self._lines else f"{self._size} bytes"

    def channel(self, message: can.Message) -> str:
        """The name of a message's channel; formats that number their channels count from 0, .trc from 1."""
        name: Any = message.channel  # by its types perhaps several; in a log it is one
        if isinstance(name, str) and not name.isdigit():
            return name
        return f"can{max(int(name or 0) - (self._suffix == '.trc'), 0)}"

    def tell(self) -> int:
        """Bytes read so far."""
        with suppress(AttributeError, ValueError):  # not open yet, or closed again
            self._byte = self._file.tell()
        return self._byte

    def __iter__(self) -> Iterator[can.Message]:
        yield from self._messages(relative_timestamp=False)
        if self._lines:
            self._lines.account(self._tally)
        if self._suffix == ".blf" and (told := _told_size(self._path)) not in (None, self._size):
            # python-can takes half a container for a whole one
            there = f"its head says {told} bytes, {self._size} are there"
            self._tally.note(f"torn at frame {self.count + 1}: {there}; read up to there")

    def _messages(self, **options: Any) -> Iterator[can.Message]:
        try:
            yield from self._read(options)
        except MemoryError:
            self._tally.note(f"stopped after {self.count} frames: out of memory")
        except Exception as error:
            text = " ".join(str(error).split())[:120]
            if options and self._suffix == ".asc" and not self.count and "datetime" in text:
                self._tally.note("its date cannot be read: times count from 1970")
                yield from self._messages()
                return
            place = f"line {self._lines.count}" if self._lines else f"frame {self.count + 1}"
            why = ": ".join(filter(None, (type(error).__name__, text)))
            self._tally.note(f"torn at {place}: {why}; read up to there")

    def _read(self, options: dict[str, Any]) -> Iterator[can.Message]:
        reads = {".asc": AscLines}.get(self._suffix, WholeLines)
        self._lines = reads(self._path) if self._suffix in TEXT else None
        opens: Any = can.io.player.MESSAGE_READERS[self._suffix]  # by its types none takes a file
        with opens(self._lines or str(self._path), **options) as reader:
            self._file = self._lines or reader.file
            for message in reader:
                self.count += 1
                if self._lines:
                    # what stands before the first frame is the file's head
                    self._silent(self._lines.silent - 1 if self.count > 1 else 0)
                    if message.timestamp > _DATED_S:
                        message.timestamp -= self._lines.shift_s
                yield message
            if self._lines:
                self._silent(self._lines.silent)

    def _silent(self, lines: int) -> None:
        assert self._lines
        self._tally.skip("line without a frame", max(lines, 0))
        self._lines.silent = 0


def _told_size(path: Path) -> int | None:
    """The length that the head of a BLF file tells, bytes; None without such a head."""
    with path.open("rb") as file:
        head = file.read(24)
    return int.from_bytes(head[16:24], "little") if head.startswith(b"LOGG") else None
