"""The monitor as a process on a loopback bus: how late it is, what it loses, what it costs, what a kill takes."""

import random
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import can
import numpy as np

from benchmarks import paper_rig
from benchmarks.loopback import (
    FILLER,
    Timed,
    Viewer,
    connected,
    cpu_s,
    hub,
    lines_of,
    memory_MB,
    monitor,
    play,
    rig_frames,
    timed,
    with_filler,
)  # fmt: skip
from benchmarks.measure import Row, say, table
from drivers.budget import Budget
from drivers.frames import Tally
from drivers.logs.candump import read_candump
from drivers.logs.truth import read_truth
from drivers.recordings import read_joined, read_recording
from drivers.virtual_rig import frame_table, simulate, write
from estimator.accuracy.review import review
from estimator.batch.replay import replay
from estimator.record import Array

STATUS, ESTIMATE = 0x214, 0x610
RATE_S, FULL_S, FULL_RATE = 150.0, 300.0, 8000
DAY_S, DAY_SPEED_UP, CYCLES, FULL_H = 86_400.0, 100.0, 24, 6
KILLS, RIG_SPEED_UP = 20, 60


def at_its_own_rate() -> list[Row]:
    """Two minutes and a half of a drive: latency of each tick, and processor time of the monitor."""
    with tempfile.TemporaryDirectory() as name, hub() as port, monitor(port, Path(name), "--publish") as process:
        heard: list[float] = []
        with connected(port) as bus, connected(port) as ear:
            notifier = can.Notifier(
                ear, [lambda m: heard.append(time.monotonic()) if m.arbitration_id == ESTIMATE else None]
            )
            before, began = cpu_s(process.pid), time.monotonic()
            instants, ids = play(bus, rig_frames(RATE_S))
            share = (cpu_s(process.pid) - before) / (time.monotonic() - began)
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
            before, began = cpu_s(process.pid), time.monotonic()
            _, ids = play(bus, with_filler(rig_frames(FULL_S), FULL_RATE))
            seconds = time.monotonic() - began
            share = (cpu_s(process.pid) - before) / seconds
            time.sleep(3.0)
        (log,) = (folder / "rec").glob("*.log")
        table_, _ = read_candump(log, Tally(), Budget())
        ticks = [line for line in lines_of(folder) if not line["provisional"]]
    numbers = table_.data[table_.id == FILLER].view(">u8").ravel()
    in_order = np.array_equal(numbers, np.arange((ids == FILLER).sum()))
    lost, scans = len(ids) - len(table_) + (not in_order), int((ids == STATUS).sum())
    return [
        Row(f"frames sent in {seconds:.0f} s", f"{len(ids)}, {len(ids) / seconds:.0f}/s"),
        _below("  not in the recording, or out of order", lost, 0, "frames"),
        _below("  ticks missed", scans - sum(line["channels"] == 15 for line in ticks), 0, "ticks"),
        Row("  processor of the monitor", f"{100 * share:.0f} % of a core"),
    ]


def a_day(seconds: float = DAY_S, speed_up: float = DAY_SPEED_UP) -> list[Row]:
    """A day of signals, faster than the rig, with a viewer: memory by the hour, how late the viewer is, and the last
    estimate beside review's."""
    with tempfile.TemporaryDirectory() as name, hub() as port:
        folder, hours = Path(name), list[tuple[float, float, float]]()
        frames = iter(list(rig_frames(seconds, cycles=CYCLES)))
        how = "--speed-up", str(speed_up), "--view", "native"
        with monitor(port, folder, *how) as process, Viewer(folder) as viewer, connected(port) as bus:

            def watched() -> Iterator[Timed]:
                for due, message in frames:
                    if due >= 3600.0 * (len(hours) + 1):
                        late_s = (lines_of(folder)[-1]["t"] - viewer.time_s()) / speed_up
                        hours.append((memory_MB(process.pid), memory_MB(viewer.process.pid), late_s))
                        say("  {} h: {:.0f} MB, viewer {:.0f} MB, {:.1f} s late".format(len(hours), *hours[-1]))
                    yield due, message

            began = time.monotonic()
            play(bus, watched(), speed_up)
            took_s = time.monotonic() - began
            time.sleep(5.0)
        last = [line for line in lines_of(folder) if not line["provisional"]]
        rig = paper_rig.rig()
        _, recording = read_joined(sorted((folder / "rec").glob("*.log")), rig)
        track = replay(paper_rig.model(), rig, recording)
    at = int(np.searchsorted(track.time_s, last[-1]["t"] - 1e-6))
    apart = abs(last[-1]["elongation_um"] - float(track.elongation_um[at]))
    memory, seen, late = np.array(hours).T
    first, last_hours, viewers = (_slope(column) for column in (memory[1:], memory[-FULL_H:], seen[1:]))
    return [
        Row(f"{seconds / 3600:.0f} h of signals", f"in {took_s:.0f} s, {len(last)} ticks"),
        Row("memory of the monitor after 1 h and at the end", f"{memory[0]:.0f} MB, {memory[-1]:.0f} MB"),
        Row("  slope after the first hour, while the store of the views fills", f"{first:.3g} MB/h"),
        _below(f"  slope of the last {FULL_H} hours, when it is full", last_hours, 0.5, "MB/h"),
        Row("memory of a viewer after 1 h and at the end", f"{seen[0]:.0f} MB, {seen[-1]:.0f} MB"),
        Row("  slope after the first hour", f"{viewers:.3g} MB/h"),
        _below("what the viewer shows, behind the newest tick, at most", float(late.max()), 2.0, "s"),
        Row("last estimate less that of review --join", f"{apart:.1e} um", apart, 1e-9),
    ]


def _slope(hourly: Array) -> float:
    return float(np.polyfit(np.arange(len(hourly)), hourly, 1)[0])


def cooldown() -> list[Row]:
    """A drive and the hour after it, no displacement reading meanwhile: the errors live, and of review on the log."""
    rig, model = paper_rig.rig(), paper_rig.model()
    with tempfile.TemporaryDirectory() as name, hub() as port:
        folder = Path(name)
        run = simulate("FS-20", seed=5, cycles=1)
        recording = read_recording(write(run, folder / "run.log"), rig)
        truth = read_truth(folder / "run.log")
        assert truth is not None
        with monitor(port, folder, "--speed-up", str(RIG_SPEED_UP)), connected(port) as bus:
            play(bus, timed(frame_table(run).messages()), RIG_SPEED_UP)
            time.sleep(2.0)
        lines = [line for line in lines_of(folder) if not line["provisional"]]
    told = review(recording, rig, model, truth.at(recording.time_s))
    at, estimate = (np.array([line[key] for line in lines], dtype=float) for key in ("t", "elongation_um"))
    stop = float(recording.time_s[np.flatnonzero(told.cooling)[0]])
    cooling = (at > stop) & (at <= stop + 3600) & (at <= recording.time_s[-1])
    worst = float(np.abs(truth.at(at[cooling]) - estimate[cooling]).max())
    expected = told.accuracy("filter").cooldown_max_um
    return [
        Row("worst error in the hour after a drive, live", f"{worst:.2f} um"),
        Row("  the same by review of the rig's own log", f"{expected:.2f} um"),
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


def markdown(*names: str) -> str:
    """Measure everything, or some of it; the table."""
    parts = {"rate": at_its_own_rate, "full": full_bus, "cooldown": cooldown, "kill": killed, "day": a_day}
    rows = []
    for name in names or parts:
        say(name)
        rows += parts[name]()
    says = ["Hub, rig and monitor in three processes on the loopback, the monitor recording and writing JSON lines."]
    return table("Live: the monitor on a bus", rows, says)
