"""Logs that python-can reads: in a process of its own, so that a file that loops or inflates can really be ended.

python-can's BLF reader loops for ever on some files of 256 bytes and takes half a gigabyte for others of 300 kB; a
thread could not be stopped and memory not be limited.
"""

from __future__ import annotations

import json
import os
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from drivers.budget import Budget
from drivers.frames import FRAME, Frames, Tally

HEAD = struct.Struct("<cId")  # kind of block, bytes that follow, share of the file read
_BYTES_PER_S = 5e6  # a large file may take longer to its first frame


def read_outside(
    path: Path, tally: Tally, budget: Budget, progress: Callable[[float], None] | None = None
) -> tuple[Frames, str]:
    """All classic data frames that python-can finds, and what was found, in words."""
    suffix = path.suffix.lower()
    size = path.stat().st_size
    memory = budget.memory + 8 * size + (4_000_000_000 if suffix == ".mf4" else 0)
    child = _start(path, memory)
    watch = _Watch(child, budget, budget.stall_s + size / _BYTES_PER_S)
    try:
        blocks, account = _receive(child.stdout, watch, budget, progress)  # type: ignore[arg-type]
    finally:
        watch.end()
    for reason, count in account.get("skipped", {}).items():
        tally.skip(reason, count)
    for sentence in account.get("notes", ()):
        tally.note(sentence)
    unit = "line" if suffix in {".asc", ".csv", ".trc"} else "frame"
    table = np.concatenate(blocks) if blocks else np.empty(0, FRAME)
    if watch.why:
        tally.note(f"stopped after {len(table)} frames: {watch.why}")
    elif "found" not in account:
        tally.note(f"stopped after {len(table)} frames: the reader died, probably out of memory")
    return Frames.of(table, unit), account.get("found", f"{size} bytes")


def _start(path: Path, memory: int) -> subprocess.Popen[bytes]:
    paths = os.pathsep.join(os.path.abspath(entry) for entry in sys.path)
    environment = {**os.environ, "PYTHONPATH": paths, "OPENBLAS_NUM_THREADS": "1"}
    # -P: a can.py in the working directory must not be taken for python-can
    command = [sys.executable, "-P", "-m", "drivers.logs.outside_reader", str(path.resolve()), str(memory)]
    return subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
    )


def _receive(
    pipe: IO[bytes], watch: _Watch, budget: Budget, progress: Callable[[float], None] | None
) -> tuple[list[NDArray[np.void]], dict[str, Any]]:
    """Blocks of frames until the account, which comes last; a killed reader's pipe just ends."""
    blocks: list[NDArray[np.void]] = []
    count = 0
    while len(head := pipe.read(HEAD.size)) == HEAD.size:
        kind, size, share = HEAD.unpack(head)
        body = pipe.read(size)
        if len(body) < size:
            break
        if kind == b"A":
            return blocks, json.loads(body)
        watch.alive()
        blocks.append(np.frombuffer(body, FRAME))
        count += len(blocks[-1])
        if progress:
            progress(min(share, 1.0))
        if why := budget.spent(count, 0, late=False):
            watch.kill(why)
    return blocks, {}


class _Watch:
    """Kills the reader when it sends nothing for too long, or takes too long in all."""

    def __init__(self, child: subprocess.Popen[bytes], budget: Budget, stall_s: float) -> None:
        self.why = ""
        self._child = child
        self._stall_s = stall_s
        self._total_s = budget.seconds
        self._begin = self._heard = time.monotonic()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def alive(self) -> None:
        self._heard = time.monotonic()

    def kill(self, why: str) -> None:
        self.why = self.why or why
        self._child.kill()

    def end(self) -> None:
        """No process and no thread stays behind."""
        self._over.set()
        self._thread.join()
        self._child.kill()
        self._child.wait()
        if self._child.stdout:
            self._child.stdout.close()

    def _run(self) -> None:
        while not self._over.wait(0.05):
            now = time.monotonic()
            if now - self._begin > self._total_s:
                self.kill(f"reading took {self._total_s:g} s")
            elif now - self._heard > self._stall_s:
                self.kill(f"the reader gave no frame for {self._stall_s:.0f} s")
