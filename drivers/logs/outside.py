"""Logs that python-can reads: in a process of its own, so that a file that loops or inflates can really be ended.

python-can's BLF reader loops for ever on some files of 256 bytes and takes half a gigabyte for others of 300 kB; a
thread could not be stopped and memory not be limited. What counts is the processor time that the reader takes: on a
busy machine a good file needs longer, by the clock on the wall.
"""

import json
import math
import os
import queue
import re
import struct
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np

from drivers.budget import Budget
from drivers.frames import FRAME, Frames, Tally

HEAD = struct.Struct("<cIIdd")  # of a block: its kind, frames in it, bytes that follow, share read, processor time
CLASSIC, EVERY = "classic", "every"  # data frames as FRAME; frames of all kinds, Received, by marshal
_BYTES_PER_S = 5e6  # a large file may take longer to its first frame
_PER_BYTE = 100  # frames: no compression makes a frame smaller
_WAITING = 64  # blocks that are not taken yet
_SILENT_S = 300.0  # by the clock on the wall: the reader says ten times a second how far it is
_GONE = {b"": "the reader died, probably out of memory", b"?": "the reader does not answer"}


class Block(NamedTuple):
    """What the reader sends: frames (kind F, of which there may be none) or, at last, its account (kind A).

    share   of the file that is read      used_s  processor time of the reader so far
    """

    kind: bytes
    frames: int
    share: float
    used_s: float
    body: bytes


class Outside:
    """One log in a process of its own, until the budget is spent; `tally` hears what was no frame and where it ended.

    frames  so far;  found  what was read, in words;  buses  their names, once the account has come
    """

    def __init__(self, path: Path, tally: Tally, budget: Budget, how: str) -> None:
        self.frames = 0
        self._path, self._tally, self._budget, self._how = path, tally, budget, how
        self._size = path.stat().st_size
        self.found = f"{self._size} bytes"
        self.buses: tuple[str, ...] = ("can0",)

    def __iter__(self) -> Iterator[Block]:
        mf4 = 4_000_000_000 if self._path.suffix.lower() == ".mf4" else 0
        child = _start(self._path, self._how, self._budget.memory + 8 * self._size + mf4)
        blocks: queue.Queue[Block] = queue.Queue(_WAITING)
        thread = threading.Thread(target=_pass_on, args=(child.stdout, blocks), daemon=True)
        thread.start()
        try:
            yield from self.within_budget(blocks)
        finally:
            child.kill()
            child.wait()
            while thread.is_alive():  # it may wait for a place
                blocks.queue.clear()
                thread.join(0.01)

    def within_budget(self, blocks: queue.Queue[Block]) -> Iterator[Block]:
        """Blocks of frames until the account comes; it is told why it does not, if the reader has to be ended."""
        began_s = newest_s = math.nan
        why = ""
        while not why:
            block = _next(blocks)
            if block.kind == b"A":
                self._account(block.body)
                return
            if math.isnan(began_s):
                began_s = newest_s = block.used_s  # how long it takes to start is no fault of the file
            if block.frames:
                newest_s = block.used_s
                self.frames += block.frames
                yield block
            why = _GONE.get(block.kind) or self._spent(block.used_s - began_s, block.used_s - newest_s)
        self._tally.note(f"stopped after {self.frames} frames: {why}")

    def _spent(self, used_s: float, idle_s: float) -> str:
        stall_s = self._budget.stall_s + self._size / _BYTES_PER_S
        if idle_s > stall_s:
            return f"the reader gave no frame for {stall_s:.0f} s"
        if self.frames > _PER_BYTE * self._size:
            return f"{self._size} bytes cannot hold more, the reader goes round in circles"
        return self._budget.spent(self.frames, 0, late=used_s >= self._budget.seconds)

    def _account(self, text: bytes) -> None:
        account = json.loads(text)
        self.found, self.buses = account["found"], tuple(account["buses"]) or self.buses
        for reason, count in account["skipped"].items():
            self._tally.skip(reason, count)
        for sentence in account["notes"]:
            self._tally.note(sentence)


def read_outside(
    path: Path, tally: Tally, budget: Budget, progress: Callable[[float], None] | None = None
) -> tuple[Frames, str]:
    """All classic data frames that python-can finds, and what was found, in words."""
    outside = Outside(path, tally, budget, CLASSIC)
    tables = [np.empty(0, FRAME)]
    for block in outside:
        tables.append(np.frombuffer(block.body, FRAME))
        if progress:
            progress(min(block.share, 1.0))
    unit = "line" if path.suffix.lower() in {".asc", ".csv", ".trc"} else "frame"
    buses = max(int(table["bus"].max(initial=0)) for table in tables) + 1
    names = [*outside.buses, *(f"bus {k + 1}" for k in range(len(outside.buses), buses))]
    if path.suffix.lower() in {".asc", ".blf", ".trc"}:  # they number their channels from 1
        names = [re.sub(r"^can(\d+)$", lambda k: f"{k[0]} = channel {int(k[1]) + 1}", name) for name in names]
    return Frames.of(tables, unit, names), outside.found


def _start(path: Path, how: str, memory: int) -> subprocess.Popen[bytes]:
    paths = os.pathsep.join(os.path.abspath(entry) for entry in sys.path)
    environment = {**os.environ, "PYTHONPATH": paths, "OPENBLAS_NUM_THREADS": "1"}
    # -P: a can.py in the working directory must not be taken for python-can
    command = [sys.executable, "-P", "-m", "drivers.logs.outside_reader", str(path.resolve()), how, str(memory)]
    return subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
    )


def _next(blocks: queue.Queue[Block]) -> Block:
    try:
        return blocks.get(timeout=_SILENT_S)
    except queue.Empty:
        return Block(b"?", 0, 0.0, 0.0, b"")


def _pass_on(pipe: IO[bytes], blocks: queue.Queue[Block]) -> None:
    """Pass on what the reader sends, and an empty block at its end; a killed reader's pipe just ends."""
    with pipe:
        while len(head := pipe.read(HEAD.size)) == HEAD.size:
            kind, frames, size, share, used_s = HEAD.unpack(head)
            body = pipe.read(size)
            if len(body) < size:
                break
            blocks.put(Block(kind, frames, share, used_s, body))
    blocks.put(Block(b"", 0, 0.0, 0.0, b""))
