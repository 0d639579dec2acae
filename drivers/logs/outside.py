"""Logs that python-can reads: in a process of its own, so that a file that loops or inflates can really be ended.

python-can's BLF reader loops for ever on some files of 256 bytes and takes half a gigabyte for others of 300 kB; a
thread could not be stopped and memory not be limited.
"""

from __future__ import annotations

import json
import math
import os
import queue
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
Blocks = queue.SimpleQueue[tuple[bytes, float, bytes]]  # kind of block, share of the file read, frames or account
_BYTES_PER_S = 5e6  # a large file may take longer to its first frame


def read_outside(
    path: Path, tally: Tally, budget: Budget, progress: Callable[[float], None] | None = None
) -> tuple[Frames, str]:
    """All classic data frames that python-can finds, and what was found, in words."""
    suffix, size = path.suffix.lower(), path.stat().st_size
    child = _start(path, budget.memory + 8 * size + (4_000_000_000 if suffix == ".mf4" else 0))
    blocks: Blocks = queue.SimpleQueue()
    thread = threading.Thread(target=_pass_on, args=(child.stdout, blocks), daemon=True)
    thread.start()
    try:
        table, account, why = _receive(blocks, budget, budget.stall_s + size / _BYTES_PER_S, progress)
    finally:
        child.kill()
        child.wait()
        thread.join()
    for reason, count in account.get("skipped", {}).items():
        tally.skip(reason, count)
    for sentence in account.get("notes", ()):
        tally.note(sentence)
    if why:
        tally.note(f"stopped after {len(table)} frames: {why}")
    unit = "line" if suffix in {".asc", ".csv", ".trc"} else "frame"
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
    blocks: Blocks, budget: Budget, stall_s: float, progress: Callable[[float], None] | None
) -> tuple[NDArray[np.void], dict[str, Any], str]:
    """Frames until the account, which comes last; why there is none, if the reader had to be ended or died."""
    end = time.monotonic() + budget.seconds
    tables = [np.empty(0, FRAME)]
    count, account, why = 0, {}, ""
    patience_s = math.inf  # how long a reader takes to start is no fault of the file
    while not account and not why:
        left_s = end - time.monotonic()
        try:
            kind, share, body = blocks.get(timeout=min(patience_s, left_s))
        except (queue.Empty, ValueError):  # a time below 0 is no time to wait
            late = f"reading took {budget.seconds:g} s"
            why = late if left_s < patience_s else f"the reader gave no frame for {stall_s:.0f} s"
            break
        patience_s = stall_s
        if kind == b"A":
            account = json.loads(body)
        elif kind == b"F":
            tables.append(np.frombuffer(body, FRAME))
            count += len(tables[-1])
            why = budget.spent(count, 0, late=False)
            if progress:
                progress(min(share, 1.0))
        else:
            why = "the reader died, probably out of memory"
    return np.concatenate(tables), account, why


def _pass_on(pipe: IO[bytes], blocks: Blocks) -> None:
    """Pass on what the reader sends, and an empty block at its end; a killed reader's pipe just ends."""
    with pipe:
        while len(head := pipe.read(HEAD.size)) == HEAD.size:
            kind, size, share = HEAD.unpack(head)
            body = pipe.read(size)
            if len(body) < size:
                break
            blocks.put((kind, share, body))
    blocks.put((b"", 0.0, b""))
