"""Processes on a loopback bus: a hub, the monitor, and somebody who sends as the rig does."""

import json
import os
import signal
import subprocess
import sys
import time
from array import array
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import can
import numpy as np
from rerun.experimental import ViewerClient

from benchmarks import paper_rig
from drivers.virtual_rig import frame_table, simulate
from estimator.record import Array
from viz.viewer.address import free_port
from viz.viewer.viewer import MEMORY, connect, start

FILLER = 0x7A0

Timed = tuple[float, can.Message]


@contextmanager
def hub() -> Iterator[int]:
    """A hub in a process of its own; its port."""
    process = subprocess.Popen(
        [sys.executable, "-m", "ballscrew", "hub", "--port", "0"], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    try:
        yield int(process.stdout.readline().rpartition(":")[2])
    finally:
        process.terminate()
        process.wait()


@contextmanager
def monitor(port: int, folder: Path, *options: str) -> Iterator[subprocess.Popen[bytes]]:
    """The monitor, recording into `folder`/rec, ready to hear; SIGTERM at the end."""
    said = folder / "said.txt"
    command = [
        sys.executable, "-m", "ballscrew", "live", "--interface", "socketcand", "--channel", "can0", "--bus-kwargs",
        "host=127.0.0.1", f"port={port}", "--rig", str(paper_rig.FOLDER), "--record", str(folder / "rec"),
        "--json", str(folder / "live.jsonl"), *options,
    ]  # fmt: skip
    no_screen = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
    with said.open("w") as file:
        process = subprocess.Popen(command, stdout=file, stderr=file, env=no_screen)
        try:
            while "listening" not in said.read_text():
                time.sleep(0.05)
            yield process
        finally:
            process.send_signal(signal.SIGTERM)
            process.wait()


def views_of(folder: Path) -> str:
    """Where a viewer finds what the monitor in `folder` shows: without a screen it says so."""
    said = (folder / "said.txt").read_text()
    return next(word for word in said.split() if word.startswith("rerun+http"))


class Viewer:
    """A viewer without a window that follows the monitor in `folder`, for a `with`."""

    def __init__(self, folder: Path) -> None:
        self._port = free_port()
        arguments = ["--headless", "--window-size", "1366x768", "--memory-limit", MEMORY, "--connect", views_of(folder)]
        self.process = start(arguments, self._port)
        self._client: ViewerClient | None = None

    def time_s(self) -> float:
        """Up to which time of the rig it shows, s; NaN before it shows anything."""
        self._client = self._client or connect(self.process, self._port)
        times = [each.current_time for each in self._client.get_state().recordings if each.current_time is not None]
        return max(times, default=float("nan")) / 1e9

    def __enter__(self) -> "Viewer":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.wait()


def connected(port: int) -> can.BusABC:
    """The rig's side of the bus."""
    return can.Bus(interface="socketcand", channel="can0", host="127.0.0.1", port=port)


def rig_frames(seconds: float, cycles: int = 2) -> Iterator[Timed]:
    """Frames of the rig with the time at which each is due, s from the first."""
    return timed(frame_table(simulate("FS-20", seed=5, seconds=seconds, cycles=cycles)).messages())


def timed(messages: Iterable[can.Message]) -> Iterator[Timed]:
    first = None
    for message in messages:
        first = message.timestamp if first is None else first
        yield message.timestamp - first, message


def with_filler(frames: Iterator[Timed], rate: int) -> Iterator[Timed]:
    """The bus filled up with frames of others to so many a second; each is numbered."""
    number, filler = 0, 0.0
    for due, message in frames:
        while filler <= due:
            yield filler, can.Message(arbitration_id=FILLER, is_extended_id=False, data=number.to_bytes(8, "big"))
            number, filler = number + 1, filler + 1.0 / rate
        yield due, message


def play(bus: can.BusABC, frames: Iterable[Timed], speed_up: float = 1.0) -> tuple[Array, Array]:
    """Send all when due: the instant and the id of each."""
    begin = time.monotonic()
    instants, ids = array("d"), array("I")
    for due, message in frames:
        wait = begin + due / speed_up - time.monotonic()
        if wait > 0:
            time.sleep(wait)
        bus.send(message)
        instants.append(time.monotonic())
        ids.append(message.arbitration_id)
    return np.array(instants), np.array(ids)


def lines_of(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "live.jsonl").read_text().splitlines()]


def cpu_s(pid: int) -> float:
    """Processor time of a process."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_MB(pid: int) -> float:
    """Resident memory of a process."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
