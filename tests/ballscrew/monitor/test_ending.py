"""A session ends: with its bus, with a backlog, and not by a defect of ours."""

from dataclasses import replace

import pytest

from ballscrew.monitor import session as loop
from ballscrew.monitor.monitor import Monitor
from ballscrew.monitor.session import Session
from drivers.received import Notice
from estimator.errors import SetupError
from tests.ballscrew.monitor.conftest import Clock, Receiver
from tests.live_fake import STATUS


def test_the_end_does_not_wait_for_thousands_of_ticks(paper, frames, monkeypatch):
    """After 50 minutes of silence one frame closes 3000 ticks; who asks for the end then gets it."""
    monkeypatch.setattr(loop, "DRAIN_S", 0.0)
    scan = [f for f in frames if f.id == STATUS][20]
    after = [f._replace(time_s=f.time_s + 3000.0) for f in frames if f.time_s > scan.time_s]
    said, ticks = [], []
    monitor = Monitor(paper[1], replace(paper[0], log=replace(paper[0].log, scan_number=None)))
    items = [f for f in frames if f.time_s <= scan.time_s] + after
    live = Session(monitor, Receiver(items), Clock(), "a bus", lambda text, level: said.append(text), ticks.append)
    live.run(lambda: len(ticks) < 50, lambda status: None)
    live.finish()
    assert len(ticks) == 50
    assert said[-1] == "ended behind the bus: what came last is not in the estimate"


def test_the_end_does_not_wait_for_a_backlog_without_ticks(session, frames, monkeypatch):
    monkeypatch.setattr(loop, "DRAIN_S", 0.0)
    live, said, _ = session(frames[:500])
    live.receiver.items = [f._replace(id=0x7FF) for f in frames]
    live.finish()
    assert not live.receiver.items
    assert live.monitor.tally.counts().get("unknown id 0x7FF", 0) == 0
    assert said[-1].startswith("ended behind the bus")


def test_a_defect_of_ours_is_told_once_and_the_loop_goes_on(session, frames, monkeypatch):
    feed = Monitor.feed

    def failing(monitor: Monitor, frame) -> list:
        if 500 < len(seen) < 600:
            seen.append(frame)
            raise ZeroDivisionError("a defect")
        seen.append(frame)
        return feed(monitor, frame)

    seen: list = []
    monkeypatch.setattr(Monitor, "feed", failing)
    live, said, ticks = session(frames)
    assert said.count("the estimate failed and begins anew: ZeroDivisionError: a defect") == 1
    assert len(ticks) > 30
    assert live.latest.trust.valid


def test_an_interface_that_cannot_be_is_the_end(session):
    Receiver.failure = SetupError("--interface nonsense: no such interface")
    try:
        with pytest.raises(SetupError, match="nonsense"):
            session([Notice("x")])
    finally:
        Receiver.failure = None
