"""One file of a recording: whole lines only, and beside it NAME.json, which says what it is."""

import errno
import json
import os
from collections.abc import Mapping
from contextlib import suppress
from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from typing import Any

# fdatasync leaves out the time of the last change, which costs a second write; not every system has it.
_data_to_disk = getattr(os, "fdatasync", os.fsync)


class Part:
    """A new file, named after the time of its first frame; never one that is there already.

    The thread that appends never waits for the disk: `sync` and `finish` are for another.
    """

    def __init__(self, folder: Path, number: int, before: str | None, first_s: float) -> None:
        self.path, self._fd = _create(folder, first_s)
        self.number = number
        self.before = before
        self.first_s = self.last_s = first_s
        self.frames = 0
        self.size = 0
        self._torn = self._told = self._gone = False

    def append(self, line: bytes, time_s: float) -> None:
        """Write one line, all of it or nothing: else an OSError, and no half line stays."""
        if self._torn:
            self._cut()
        done = os.write(self._fd, line)
        if done < len(line):
            self._cut()
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        if not self.frames:
            self.first_s = time_s
        self.last_s = time_s
        self.frames += 1
        self.size += done

    def sync(self, about: Mapping[str, Any]) -> None:
        """What is written so far is on the disk, its name too, and the sidecar exists."""
        _data_to_disk(self._fd)
        if not self._told:
            self._tell(about, closed=False)
            self._told = True

    def is_gone(self) -> bool:
        """Whether somebody deleted or renamed it: what is written goes where nobody looks."""
        self._gone = self._gone or not self.path.exists()
        return self._gone

    def finish(self, about: Mapping[str, Any]) -> None:
        """No more frames come: to the disk, with a sidecar that says so."""
        try:
            if not self.is_gone():
                _data_to_disk(self._fd)
                self._tell(about, closed=True)
        finally:
            os.close(self._fd)

    def _cut(self) -> None:
        self._torn = True
        os.ftruncate(self._fd, self.size)
        self._torn = False

    def _tell(self, about: Mapping[str, Any], closed: bool) -> None:
        sidecar = {
            "about": about,
            "part": self.number,
            "before": self.before,
            "first_s": self.first_s,
            "last_s": self.last_s,
            "frames": self.frames,
            "closed": closed,
        }
        text = json.dumps(sidecar, indent=2, ensure_ascii=False, default=str) + "\n"
        _replace(self.path.with_suffix(".json"), text.encode())


def utc(time_s: float) -> datetime:
    """The instant `time_s` after 1970; now, if a stamp is no time at all."""
    try:
        return datetime.fromtimestamp(time_s, UTC)
    except (ValueError, OverflowError, OSError):
        return datetime.now(UTC)


def _create(folder: Path, first_s: float) -> tuple[Path, int]:
    stem = f"{utc(first_s):%Y-%m-%dT%H-%M-%SZ}"
    for number in count(1):
        path = folder / f"{stem}{f'-{number}' if number > 1 else ''}.log"
        if path.with_suffix(".json").exists():
            continue
        with suppress(FileExistsError):
            flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND | getattr(os, "O_BINARY", 0)
            return path, os.open(path, flags, 0o644)
    raise AssertionError("unreachable")


def _replace(path: Path, text: bytes) -> None:
    """Write a file so that it is the old one or the new one, also after a power cut."""
    draft = path.with_name(f"{path.name}.part")
    try:
        with draft.open("wb") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)
    except OSError:
        draft.unlink(missing_ok=True)
        raise
    _folder_to_disk(path.parent)


def _folder_to_disk(folder: Path) -> None:
    if os.name == "nt":
        return  # folders cannot be opened there
    fd = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(fd)
    finally:
        os.close(fd)
