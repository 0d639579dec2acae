"""Every frame of a bus into candump text, one write a frame: neither kill -9 nor a power cut takes more than a second.

A new file begins after some hours or megabytes. A helper thread brings what is written to the disk, so that who
receives never waits for it.
"""

import errno
import math
import threading
import time
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from drivers.budget import Budget
from drivers.logs.candump_line import line_of
from drivers.received import Received
from drivers.recorder.folder_lock import lock_folder
from drivers.recorder.part import Part, utc

_RETRY_S = 1.0
_MOST_NOTES = 50
_MOST_STRAYS = 5
_FULL = {errno.ENOSPC, errno.EDQUOT}


class Recorder:
    """Records into `folder`, which only one recorder at a time may use.

    about       what the sidecar of each file says of the rig
    size_bytes  a file does not get longer
    hours       nor does it hold more, by the frames' stamps
    sync_s      s between two syncs: what a power cut may take
    own         id and kind of messages that are not the rig's: without the rig it is silent

    path     file that is written; the folder until the first frame comes
    frames   recorded so far
    lost     frames that the disk did not take
    trouble  what is wrong now, one sentence; empty: all is well
    notes    what went wrong and is over
    """

    def __init__(
        self, folder: Path, about: Mapping[str, Any], *, size_bytes: int = 500_000_000, hours: float = 24.0,
        sync_s: float = 1.0, own: Collection[tuple[int, bool]] = (),
    ) -> None:  # fmt: skip
        self.path = self._folder = Path(folder)
        self.frames = self.lost = 0
        self.notes: list[str] = []
        self._about, self._size_bytes, self._span_s = dict(about), size_bytes, hours * 3600.0
        self._part: Part | None = None
        self._parts = 0
        self._own, self._rig_s, self._strays = own, math.inf, 0
        self._finished: list[Part] = []
        self._not_taken = self._not_synced = ""
        self._retry_at = 0.0
        self._lost_since = (0.0, 0)  # stamp of the first frame lost, frames lost before it
        self._mutex = threading.Lock()
        self._wake, self._over = threading.Event(), threading.Event()
        self._held = lock_folder(self._folder)
        self._helper = threading.Thread(target=self._keep, args=(sync_s,), daemon=True, name="recorder")
        self._helper.start()

    def write(self, frame: Received) -> None:
        """Record one frame. Never raises and never waits for the disk: a frame that it does not take is counted."""
        line = line_of(frame).encode("ascii", "replace")
        with self._mutex:
            if self._over.is_set() or (self._not_taken and time.monotonic() < self._retry_at):
                self.lost += 1
                return
            try:
                rigs = frame.kind == "data" and (frame.id, frame.extended) not in self._own
                self._append(line, frame.time_s, rigs)
            except OSError as error:
                self._failed(error, frame.time_s)
            else:
                self.frames += 1
                if self._not_taken:
                    self._works_again(frame.time_s)

    @property
    def trouble(self) -> str:
        return self._not_taken or self._not_synced

    def close(self) -> None:
        """Bring everything to the disk and let go of the folder."""
        with self._mutex:
            if self._over.is_set():
                return
            self._over.set()
            if self._part:
                self._finished.append(self._part)
                self._part = None
        self._wake.set()
        self._helper.join()
        self._sync()
        self._held.release()

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()

    def _append(self, line: bytes, time_s: float, rigs: bool) -> None:
        part = self._part
        if part is None or (part.frames and self._is_full(part, len(line), time_s)):
            part = self._next(time_s)
        part.append(line, time_s)
        if rigs:
            self._strays += math.inf > self._rig_s > time_s + Budget().gap_s
            self._rig_s = time_s

    def _is_full(self, part: Part, more: int, time_s: float) -> bool:
        """What comes after a long silence is another recording, and has a file of its own.

        Stamps that come back from the future again and again must not begin a file each.
        """
        silent = time_s - self._rig_s > Budget().gap_s and self._strays < _MOST_STRAYS
        return silent or part.size + more > self._size_bytes or time_s - part.first_s >= self._span_s

    def _next(self, time_s: float) -> Part:
        before = self.path.name if self._parts else None
        part = Part(self._folder, self._parts + 1, before, time_s)
        self._parts += 1
        if self._part:
            self._finished.append(self._part)
        self._part, self.path = part, part.path
        self._wake.set()
        return part

    def _failed(self, error: OSError, time_s: float) -> None:
        if not self._not_taken:
            self._lost_since = time_s, self.lost
        self.lost += 1
        self._retry_at = time.monotonic() + _RETRY_S
        since = f"{utc(self._lost_since[0]):%H:%M:%S}"
        self._not_taken = f"{_reason(error)}: {self._folder}: frames not recorded since {since} UTC"

    def _works_again(self, time_s: float) -> None:
        since, before = self._lost_since
        span = f"from {utc(since):%H:%M:%S} to {utc(time_s):%H:%M:%S} UTC"
        self._note(f"{self.lost - before} frames not recorded {span}: {self._not_taken.partition(':')[0]}")
        self._not_taken = ""

    def _keep(self, sync_s: float) -> None:
        while not self._over.is_set():
            self._wake.wait(sync_s)
            self._wake.clear()
            self._sync()

    def _sync(self) -> None:
        with self._mutex:
            finished, self._finished = self._finished, []
            part = self._part
        for old in finished:
            self._finish(old)
        if part is None:
            return
        try:
            if part.is_gone():
                self._leave(part)
                return
            part.sync(self._about)
        except OSError as error:
            self._not_synced = f"{_reason(error)}: {part.path}: a power cut may take more than the last second"
        else:
            self._not_synced = ""

    def _finish(self, part: Part) -> None:
        try:
            part.finish(self._about)
        except OSError as error:
            self._note(f"{part.path}: closed, but its end or its sidecar may be missing: {_reason(error)}")

    def _leave(self, part: Part) -> None:
        """The file was deleted or renamed: the next frame begins a new one."""
        with self._mutex:
            if self._part is part:
                self._part = None
                self._finished.append(part)
        self._not_synced = ""
        self._note(f"{part.path.name} was deleted or renamed while it was written; a new file begins")

    def _note(self, sentence: str) -> None:
        if len(self.notes) < _MOST_NOTES:  # a disk at its limit fails again and again
            self.notes.append(sentence)


def _reason(error: OSError) -> str:
    return "disk full" if error.errno in _FULL else (error.strerror or str(error)).lower()
