"""ballscrew live as people run it: a process of its own on a bus, stopped by a signal, killed, started twice."""

import json
import os
import re
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import can
import numpy as np
import pytest

from ballscrew.monitor.monitor import Monitor
from drivers.budget import Budget
from drivers.bus.hub import Hub
from drivers.frames import Tally
from drivers.logs.candump import read_candump
from drivers.recorder.recorder import Recorder
from drivers.recordings import read_recording
from estimator.batch.replay import replay
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from tests.conftest import PAPER, ended
from tests.hub_fake import hub_running
from tests.live_fake import DRIVE, Frames, dropped, rig_frames, since
from tests.processes import PATIENCE_S, started, until

SPEED_UP, END_S = 60, 90.0


@contextmanager
def bus(port: int) -> Iterator[can.BusABC]:
    with can.Bus(interface="socketcand", channel="can0", host="127.0.0.1", port=port) as opened:
        yield opened


@contextmanager
def live(port: int, folder: Path, *options: str) -> Iterator[subprocess.Popen[str]]:
    """The monitor, recording, until the block ends; it writes its lines to live.jsonl and what it says to said.txt."""
    words = [
        "live", "--interface", "socketcand", "--channel", "can0", "--bus-kwargs",
        "host=127.0.0.1", f"port={port}", "--rig", str(PAPER), "--record", str(folder / "rec"), "--json",
        str(folder / "live.jsonl"), *options,
    ]  # fmt: skip
    env = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    with (
        (folder / "said.txt").open("w") as said,
        started("ballscrew", *words, stdout=said, stderr=said, env=env) as process,
    ):
        yield process


def send(port: int, frames: Frames, speed_up: float = SPEED_UP) -> list[can.Message]:
    """All frames when they are due; what came back meanwhile."""
    heard: list[can.Message] = []
    with bus(port) as opened:
        begin = time.monotonic()
        for frame in frames:
            wait = begin + (frame.time_s - frames[0].time_s) / speed_up - time.monotonic()
            while wait > 0 and (message := opened.recv(min(wait, 0.01))) is not None:
                heard.append(message)
            time.sleep(max(0.0, begin + (frame.time_s - frames[0].time_s) / speed_up - time.monotonic()))
            opened.send(can.Message(arbitration_id=frame.id, is_extended_id=False, data=frame.data))
        while (message := opened.recv(0.3)) is not None and len(heard) < 200:
            heard.append(message)
    return heard


def said(folder: Path, words: str) -> None:
    """Wait until the monitor has said so."""
    until(lambda: words in (folder / "said.txt").read_text(), f"the monitor never said: {words}")


def lines(folder: Path) -> list[dict]:
    path = folder / "live.jsonl"
    if not path.exists():
        return []
    whole, _, _ = path.read_text().rpartition("\n")  # the last may be half written
    return [json.loads(line) for line in whole.splitlines()]


def final(folder: Path) -> list[dict]:
    """Lines of ticks that are complete: on a busy machine many are said before."""
    return [line for line in lines(folder) if not line["provisional"]]


def recorded(folder: Path) -> list[tuple[int, bytes]]:
    (log,) = (folder / "rec").glob("*.log")
    table, _ = read_candump(log, Tally(), Budget())
    found = [(int(i), bytes(d[:n])) for i, d, n in zip(table.id, table.data, table.dlc)]
    return [pair for pair in found if pair[0] not in (0x610, 0x611)]


def test_two_processes_record_estimate_and_publish(frames, tmp_path):
    with hub_running() as port, live(port, tmp_path, "--speed-up", str(SPEED_UP), "--publish") as process:
        said(tmp_path, "listening on can0")
        refused(port, tmp_path, process)
        heard = send(port, frames)
        until(lambda: len(final(tmp_path)) >= 89, "no estimate of the last tick")
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE_S) == 0
    assert recorded(tmp_path) == [(f.id, f.data) for f in frames]
    (log,) = (tmp_path / "rec").glob("*.log")
    assert json.loads(log.with_suffix(".json").read_text())["closed"] is True
    rig = load_rig(PAPER)
    track = replay(load_model(PAPER / "model.toml"), rig, read_recording(log, rig))
    told = final(tmp_path)
    behind = "ended behind the bus" in (tmp_path / "said.txt").read_text()  # a busy machine: the end was cut, and said
    assert len(told) == len(track) or (behind and len(told) >= 89)
    same = np.array([line["elongation_um"] for line in told], dtype=float)
    np.testing.assert_allclose(same, track.elongation_um[: len(told)], atol=1e-9)
    assert np.isfinite(same).sum() >= 88
    assert {message.arbitration_id for message in heard} == {0x610, 0x611}
    assert told[-1]["channels"] == 15
    assert not any("position" in why for line in told for why in line["why_invalid"] or ())
    assert told[-1]["dropped"] <= 1


def test_kill_9_loses_nothing_that_is_estimated_and_without_publish_nothing_is_sent(frames, tmp_path):
    sent = [f for f in frames if f.time_s - frames[0].time_s < 60]
    with hub_running() as port, live(port, tmp_path, "--speed-up", str(SPEED_UP)) as process:
        said(tmp_path, "listening on can0")
        assert not send(port, sent)
        until(lambda: len(lines(tmp_path)) >= 58, "no estimate of what was sent")
        process.kill()
        process.wait()
    found = recorded(tmp_path)
    assert found == [(f.id, f.data) for f in sent][: len(found)]
    assert len(found) >= len(sent) - 200  # less than two seconds of the rig: its last ticks


class Stamps:
    """A hub's stamps: those that the frames have."""

    def __init__(self, frames: Frames) -> None:
        self.left = [b"%.6f" % frame.time_s for frame in frames]

    def next(self) -> bytes:
        return self.left.pop(0)


def test_after_a_stamp_that_is_ahead_and_a_silence_it_still_ends(frames, tmp_path):
    """Ahead by less than an hour, and then by what no clock says; others by the monitor alone: test_monitor."""
    end = next(k for k in range(1500, len(frames)) if frames[k].id == DRIVE)
    hub = Hub()
    ahead = [frames[end]._replace(time_s=frames[end].time_s + ahead_s) for ahead_s in (3000.0, 5.7e9)]
    hub.stamp = Stamps([*frames[:end], *ahead])
    with hub_running(hub) as port, live(port, tmp_path) as process:
        said(tmp_path, "listening on can0")
        send(port, [*frames[: end + 1], frames[end]], 1000.0)
        until(lambda: sum(line["provisional"] for line in lines(tmp_path)) >= 2, "the model never went on alone")
        size_kB = memory_kB(process.pid)
        until(lambda: sum(line["provisional"] for line in lines(tmp_path)) >= 4, "the model stopped going on")
        assert memory_kB(process.pid) < size_kB + 20_000
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE_S) == 0
    assert len(lines(tmp_path)) < 100
    assert "ended: time" in (tmp_path / "said.txt").read_text()


def memory_kB(pid: int) -> int:
    return int(re.search(r"VmRSS:\s+(\d+) kB", Path(f"/proc/{pid}/status").read_text())[1])


def refused(port: int, folder: Path, first: subprocess.Popen[str]) -> None:
    """A second instance that would record into the same folder names the first, and ends."""
    bus = ["--interface", "socketcand", "--channel", "can0", "--bus-kwargs", "host=127.0.0.1", f"port={port}"]
    _, err = ended(2, "live", *bus, "--rig", PAPER, "--record", folder / "rec")
    assert f"process {first.pid} already records there" in err


def test_a_hub_that_comes_late_goes_and_comes_back(tmp_path, frames):
    """No bus at the start, then one, then none, then one again: the estimate goes on."""
    with hub_running() as port:
        pass  # a port that is free now
    with live(port, tmp_path, "--speed-up", "20") as process:
        said(tmp_path, "bus not open yet: ConnectionRefusedError")
        for part, back in ((dropped(frames, 30), "listening on can0"), (frames[-2000:], "frames again after")):
            with hub_running(port=port):
                count = len(lines(tmp_path))
                until(lambda back=back: _nudged(port) and back in (tmp_path / "said.txt").read_text(), "not back")
                send(port, part, 20)
                until(lambda count=count: len(lines(tmp_path)) > count + 15, "no estimate")
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE_S) == 130
    assert "Traceback" not in (tmp_path / "said.txt").read_text()


def _nudged(port: int) -> bool:
    """A frame of nobody's, so that the monitor hears that the bus is there."""
    with bus(port) as opened:
        opened.send(can.Message(arbitration_id=0x7FF, is_extended_id=False))
    return True


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--channel", "can0"], "say which bus: --interface and --channel"),
        (["--interface", "nonsense", "--channel", "x"], "--interface nonsense"),
        (["--interface", "virtual", "--channel", "x", "--bus-kwargs", "a"], "--bus-kwargs a: write NAME=VALUE"),
        (["--interface", "virtual", "--channel", "x", "--speed-up", "0"], "--speed-up must be above 0"),
    ],
)
def test_wrong_usage_is_one_line(options, says):
    _, err = ended(2, "live", *options)
    assert says in err
    assert "Traceback" not in err


def test_started_again_it_goes_on_with_the_recording(tmp_path):
    """Recorded until a moment ago; what comes now is what the rig sends by now, however long the start took."""
    frames, folder = rig_frames(40.0 + 2 * PATIENCE_S), tmp_path / "rec"
    before = [frame for frame in frames if since(frames, frame) < 40.0]
    later = time.time() - before[-1].time_s
    rig = load_rig(PAPER)
    with hub_running() as port:
        bus_name = f"socketcand can0 host=127.0.0.1 port={port}"
        about = {"bus": bus_name, "rig": rig.name, "model": "model.toml", "speed_up": 1.0}
        with Recorder(folder, about) as recorder:
            for frame in before:
                recorder.write(frame._replace(time_s=round(frame.time_s + later, 6)))
        with live(port, tmp_path) as process:
            said(tmp_path, "goes on with")
            said(tmp_path, "listening on can0")
            now = time.time() - later
            coming = [frame for frame in frames if now < frame.time_s < now + 3.0]
            send(port, coming, 1.0)
            process.send_signal(signal.SIGTERM)
            assert process.wait(PATIENCE_S) == 0
    told = lines(tmp_path)
    assert all(38.0 < line["resumed_s"] < 41.0 for line in told)
    whole = Monitor(load_model(PAPER / "model.toml"), rig)
    heard = [frame for frame in frames if frame.time_s <= coming[-1].time_s]
    usual = [moment.step for frame in heard for moment in whole.feed(frame)][-1]
    last = next(line for line in reversed(told) if not line["provisional"])
    assert abs(last["elongation_um"] - usual.elongation_um) < 0.2 + 2 * last["sigma_um"]


def test_what_was_recorded_is_asked_for_unless_it_is_to_begin_anew(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr("ballscrew.commands.live.earlier", lambda folder, *_: asked.append(folder) or [])
    for words in ([], ["--fresh"], ["--speed-up", 2.0]):
        bus = ["--interface", "virtual", "--channel", "fresh", "--record", tmp_path / "rec", "--seconds", 0.01]
        ended(0, "live", *bus, *words)
    assert asked == [tmp_path / "rec"]
