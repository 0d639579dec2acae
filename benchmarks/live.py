"""The monitor as a process on a loopback bus: how late it is, what it loses, what it costs, what a kill takes."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from array import array
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import can
import numpy as np

from benchmarks.measure import Row, alone, say, table
from drivers.budget import Budget
from drivers.candump import read_candump
from drivers.frames import Tally
from drivers.recordings import read_joined
from drivers.virtual_rig import simulate
from estimator.model import load_model
from estimator.record import Array
from estimator.replay import replay
from estimator.rig_file import load_rig

RECORDINGS = Path(__file__).parents[1] / "recordings"
STATUS, ESTIMATE, FILLER = 0x214, 0x610, 0x7A0
RATE_S, FULL_S, FULL_RATE = 150.0, 300.0, 8000
DAY_S, DAY_SPEED_UP, CYCLES = 86_400.0, 200.0, 20
KILLS = 20

Timed = tuple[float, can.Message]


def markdown() -> str:
    """All tables of this study."""
    return alone("benchmarks.live")


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
        "host=127.0.0.1", f"port={port}", "--rig", str(RECORDINGS), "--record", str(folder / "rec"),
        "--json", str(folder / "live.jsonl"), *options,
    ]  # fmt: skip
    with said.open("w") as file:
        process = subprocess.Popen(command, stdout=file, stderr=file)
        try:
            while "listening" not in said.read_text():
                time.sleep(0.05)
            yield process
        finally:
            process.send_signal(signal.SIGTERM)
            process.wait()


def connected(port: int) -> can.BusABC:
    """The rig's side of the bus."""
    return can.Bus(interface="socketcand", channel="can0", host="127.0.0.1", port=port)


def rig_frames(seconds: float, **options: object) -> Iterator[Timed]:
    """Frames of the rig with the time at which each is due, s from the first."""
    first = None
    for message in simulate("FS-20", seed=5, seconds=seconds, **options).frames():
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


def at_its_own_rate() -> list[Row]:
    """Two minutes and a half of a drive: latency of each tick, and processor time of the monitor."""
    with tempfile.TemporaryDirectory() as name, hub() as port, monitor(port, Path(name), "--publish") as process:
        heard: list[float] = []
        with connected(port) as bus, connected(port) as ear:
            notifier = can.Notifier(
                ear, [lambda m: heard.append(time.monotonic()) if m.arbitration_id == ESTIMATE else None]
            )
            before, began = _cpu_s(process.pid), time.monotonic()
            instants, ids = play(bus, rig_frames(RATE_S))
            share = (_cpu_s(process.pid) - before) / (time.monotonic() - began)
            time.sleep(1.0)
            notifier.stop()
    closed = instants[ids == STATUS]
    late = 1e3 * (np.array(heard)[np.searchsorted(heard, closed)] - closed)
    return [
        Row("last frame of a tick to Estimate received by another process, p50", f"{np.median(late):.1f} ms"),
        _below("the same, p99", float(np.percentile(late, 99)), 20.0, "ms"),
        _below("processor at the rig's own rate, publishing and recording", 100 * share, 5.0, "% of a core"),
    ]


def full_bus() -> list[Row]:
    """A full bus for five minutes: is everything recorded, and every tick estimated?"""
    with tempfile.TemporaryDirectory() as name, hub() as port:
        folder = Path(name)
        with monitor(port, folder) as process, connected(port) as bus:
            before, began = _cpu_s(process.pid), time.monotonic()
            _, ids = play(bus, with_filler(rig_frames(FULL_S), FULL_RATE))
            seconds = time.monotonic() - began
            share = (_cpu_s(process.pid) - before) / seconds
            time.sleep(3.0)
        (log,) = (folder / "rec").glob("*.log")
        table_, _ = read_candump(log, Tally(), Budget())
        ticks = [line for line in _lines(folder) if not line["provisional"]]
    numbers = table_.data[table_.id == FILLER].view(">u8").ravel()
    in_order = np.array_equal(numbers, np.arange((ids == FILLER).sum()))
    lost, scans = len(ids) - len(table_) + (not in_order), int((ids == STATUS).sum())
    return [
        Row(f"frames sent in {seconds:.0f} s", f"{len(ids)}, {len(ids) / seconds:.0f}/s"),
        _below("  not in the recording, or out of order", lost, 0, "frames"),
        _below("  ticks missed", scans - sum(line["channels"] == 15 for line in ticks), 0, "ticks"),
        Row("  processor of the monitor", f"{100 * share:.0f} % of a core"),
    ]


def a_day() -> list[Row]:
    """A day of signals, faster than the rig: memory by the hour, and the last estimate beside review's."""
    with tempfile.TemporaryDirectory() as name, hub() as port:
        folder, memory, hours = Path(name), [], 0
        with monitor(port, folder, "--speed-up", str(DAY_SPEED_UP)) as process, connected(port) as bus:

            def watched() -> Iterator[Timed]:
                nonlocal hours
                for due, message in rig_frames(DAY_S, cycles=CYCLES):
                    if due >= 3600.0 * (hours + 1):
                        hours += 1
                        memory.append(_memory_MB(process.pid))
                        say(f"  {hours} h: {memory[-1]:.0f} MB")
                    yield due, message

            began = time.monotonic()
            play(bus, watched(), DAY_SPEED_UP)
            seconds = time.monotonic() - began
            time.sleep(5.0)
        last = [line for line in _lines(folder) if not line["provisional"]]
        rig = load_rig(RECORDINGS)
        _, recording = read_joined(sorted((folder / "rec").glob("*.log")), rig)
        track = replay(load_model(RECORDINGS / "model.toml"), rig, recording)
    at = int(np.searchsorted(track.time_s, last[-1]["t"] - 1e-6))
    apart = abs(last[-1]["elongation_um"] - float(track.elongation_um[at]))
    slope = float(np.polyfit(np.arange(len(memory) - 1), memory[1:], 1)[0])
    return [
        Row(f"{DAY_S / 3600:.0f} h of signals", f"in {seconds:.0f} s, {len(last)} ticks"),
        Row("memory after 1 h and at the end", f"{memory[0]:.0f} MB, {memory[-1]:.0f} MB"),
        _below("  slope after the first hour", slope, 0.5, "MB/h"),
        Row("last estimate less that of review --join", f"{apart:.1e} um", apart, 1e-9),
    ]


def killed() -> list[Row]:
    """kill -9 at random: what of all that was sent more than a second before is not in the recording?"""
    dice, worst, torn = random.Random(1), 0.0, 0
    frames = list(rig_frames(60.0))
    with hub() as port:
        for k in range(KILLS):
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                with monitor(port, folder) as process, connected(port) as bus:
                    until = dice.uniform(2.0, 8.0)
                    instants, _ = play(bus, ((due, m) for due, m in frames if due < until))
                    process.kill()
                    killed_at = time.monotonic()
                (log,) = (folder / "rec").glob("*.log")
                tally = Tally()
                found, _ = read_candump(log, tally, Budget())
                torn += tally.skipped["torn line"]
            lost = killed_at - instants[len(found) :]
            worst = max([worst, *lost])
            say(f"  kill {k + 1} of {KILLS}: {len(lost)} frames lost")
    return [
        _below(f"{KILLS} times kill -9: oldest frame lost", worst, 1.0, "s"),
        Row("  files with a torn last line, read up to there", f"{torn}"),
    ]


def _below(what: str, value: float, limit: float, unit: str) -> Row:
    return Row(what, f"{value:.3g} {unit}", float(value), limit)


def _lines(folder: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in (folder / "live.jsonl").read_text().splitlines()]


def _cpu_s(pid: int) -> float:
    """Processor time of a process."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _memory_MB(pid: int) -> float:
    """Resident memory of a process."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def main(names: Sequence[str]) -> None:
    """Measure everything, or some of it, and print the table."""
    parts = {"rate": at_its_own_rate, "full": full_bus, "day": a_day, "kill": killed}
    rows = []
    for name in names or parts:
        say(name)
        rows += parts[name]()
    says = ["Hub, rig and monitor in three processes on the loopback, the monitor recording and writing JSON lines."]
    print(table("Live: the monitor on a bus", rows, says))


if __name__ == "__main__":
    main(sys.argv[1:])
