"""The loop of live with a bus, views and a publisher that are not there: who hears what, and when."""

from __future__ import annotations

import io
import json
import os
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from ballscrew.monitor import session as loop
from ballscrew.monitor.json_lines import WAITING, JsonLines
from ballscrew.monitor.monitor import MOST_ALONE, Monitor
from ballscrew.monitor.panel import panel
from ballscrew.monitor.session import Session
from ballscrew.monitor.status import Status
from drivers.received import Notice
from estimator.errors import SetupError
from estimator.step import Mode
from tests.live_fake import DRIVE, STATUS, Frames, changed, channel, dropped, rig_frames, since
from tests.processes import until
from viz.drawing.scale import clock


class Clock:
    silent_s, trouble = 0.0, ""

    def silence(self) -> float:
        return self.silent_s


class Receiver:
    """Gives its items ten at a time."""

    state, failure, missed, dropped, errors, age_s = "open", None, 0, 0, 0, 0.0

    def __init__(self, items: list) -> None:
        self.items, self.frames = list(items), len(items)

    @property
    def waiting(self) -> bool:
        return bool(self.items)

    def start(self) -> None: ...

    def stop(self) -> None: ...

    def take(self, wait_s: float) -> list:
        found, self.items = self.items[:10], self.items[10:]
        return found


class Publisher:
    trouble, sent = "", 0

    def __init__(self) -> None:
        self.sent_valid, self.positions = [], []

    def start(self) -> None: ...

    def send(self, step, trust, position_mm) -> None:
        self.sent_valid.append((step.time_s, trust.valid))
        self.positions.append(position_mm)


class Views:
    trouble = ""

    def __init__(self) -> None:
        self.ticks, self.texts, self.states, self.judged, self.published = 0, [], [], [], []
        self.times, self.begun = [], []

    def begin(self) -> None:
        self.begun.append(self.ticks)

    def show(self, sample, step) -> None:
        self.ticks += 1

    def judge(self, time_s, why, alarms, published) -> None:
        self.judged.append((time_s, why, alarms))
        self.published.append(published)

    def say(self, time_s, text, level) -> None:
        self.texts.append((text, level))
        self.times.append(time_s)

    def stand(self, standing) -> None:
        self.states.append(standing)


@pytest.fixture(scope="module")
def frames() -> Frames:
    return rig_frames(45.0)


@pytest.fixture
def session(paper, monkeypatch):
    """session(items): all parts of it, with what was said and each status; a busy machine takes its time at the end."""
    monkeypatch.setattr(loop, "DRAIN_S", 1000.0)

    def of(items: list) -> tuple[Session, list[str], list[Status]]:
        said, ticks = [], []
        session = Session(
            Monitor(paper[1], paper[0]), Receiver(items), Clock(), "a bus", lambda text, level: said.append(text),
            ticks.append, None, Publisher(), Views(),
        )  # fmt: skip
        session.run(lambda: bool(session.receiver.items), lambda status: None)
        session.finish()
        return session, said, ticks

    return of


def test_every_tick_is_told_shown_and_published(session, frames):
    live, said, ticks = session(frames)
    assert len(ticks) == live.views.ticks >= 45
    assert len(live.publisher.sent_valid) >= 44  # the newest of each turn
    assert np.isfinite(live.publisher.positions).all()
    assert all(valid for _, valid in live.publisher.sent_valid)
    assert said == ["drive starts"]
    last = live.views.states[-1]
    assert (last.glances[-1].value, {glance.tone for glance in last.glances}) == ("ENDED", {"stale"})


def test_alarms_and_what_happens_to_the_bus_reach_the_views(session, frames):
    items = [Notice("bus lost: OSError: gone"), *dropped(frames, 30.0, [0x211])]
    live, said, _ = session(items)
    assert said[0] == "bus lost: OSError: gone"
    assert ("bus lost: OSError: gone", "WARN") in live.views.texts
    alarms = [text for text, level in live.views.texts if text.startswith("alarm: ") and level == "WARN"]
    assert any("Telemeter2 (0x211) is missing" in text for text in alarms)
    assert any(text.startswith("alarm: T05 at 415 mm is not read, since ") for text in alarms)


def test_who_relies_on_it_hears_of_a_silent_bus_before_the_next_tick(session, frames):
    live, _, _ = session(frames[:-400])
    sent = len(live.publisher.sent_valid)
    for silent_s in (0.05, 0.6, 1.4, 1.55, 1.6):
        live.clock.silent_s = silent_s
        live._idle()
        live._publish()
    assert live.publisher.sent_valid[sent:] == [(live.latest.step.time_s, False)]
    assert live.latest.mode == Mode.INVALID
    assert live.latest.trust.why == ("no news of the drive",)


def test_what_has_come_is_estimated_before_the_model_goes_on_alone(session, frames):
    """A monitor that is behind takes silence in the past for silence now, and its frames would wait for ever."""
    live, _, _ = session(frames[:-400])
    live.clock.silent_s, last = 20.0, live.latest.step.time_s
    live.receiver.items = list(frames[-400:])
    live._idle()
    assert live.latest.step.time_s == last
    live._take(live.receiver.take(0.0))
    live.receiver.items = []
    live._idle()
    assert live.latest.provisional
    assert live.latest.step.time_s <= last + MOST_ALONE


def test_what_is_shown_of_a_silent_bus_does_not_look_like_news(session, frames):
    live, _, _ = session(frames)
    live._ended, live.clock.silent_s = False, 20.0
    live._idle()
    live._shown = -np.inf
    live._show_status()
    shown = live.views.states[-1]
    assert shown.glances[-1].value == "NO FRAMES"
    assert {glance.tone for glance in shown.glances} == {"stale"}
    assert shown.table is None
    assert shown.time_s > live.monitor.ticker.clock.now


def test_a_drive_is_told_from_when_it_began(session, frames):
    live, _, _ = session(frames)
    at_s = live.views.times[live.views.texts.index(("drive starts", "INFO"))]
    assert at_s == pytest.approx(21.0, abs=1.0)
    assert live.status().motion == f"driving since {clock(at_s)}"
    assert live.views.states[-1].table.error_um.shape == (1, loop.PLACES)


def test_after_a_night_the_views_begin_anew(session, frames):
    """Once, and before anything of the new run is shown."""
    night = [frame._replace(time_s=frame.time_s + 10 * 3600.0) for frame in frames]
    live, said, _ = session([*frames, *night])
    assert "the estimate begins anew" in said
    ((before,),) = (live.views.begun,)
    assert live.views.ticks - before == pytest.approx(before, abs=2)
    assert session(frames)[0].views.begun == []


def test_a_silent_drive_alone_is_heard_of_too(session, frames):
    live, _, _ = session(dropped(frames, 40.0, [DRIVE]))
    assert live.publisher.sent_valid[-1][1] is False


def test_what_comes_late_is_not_valid(session, frames, monkeypatch):
    """A monitor that has fallen behind the bus must not pass off what was as what is."""
    monkeypatch.setattr(Receiver, "age_s", 2.0)
    live, _, ticks = session(frames)
    assert not any(valid for _, valid in live.publisher.sent_valid)
    assert ticks[-1].json()["why_invalid"] == ["the monitor is behind"]
    assert ticks[-1].json()["age_s"] == 2.0


def test_a_backlog_is_published_once(session, frames, monkeypatch):
    def everything(receiver: Receiver, wait_s: float) -> list:
        found, receiver.items = receiver.items, []
        return found

    monkeypatch.setattr(Receiver, "take", everything)
    monkeypatch.setattr(loop, "DRAIN_S", 600.0)  # however busy the machine is
    live, _, ticks = session(frames)
    assert len(ticks) >= 45
    assert len(live.publisher.sent_valid) <= 3


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


def test_validity_is_told_when_it_changes(session, frames):
    live, said, _ = session(dropped(frames, 30.0, [DRIVE], 36.0))
    told = [text for text in said if text.startswith("estimate valid")]
    assert told == ["estimate valid no longer: no news of the drive", "estimate valid again"]
    assert {why for _, why, _ in live.views.judged} >= {(), ("no news of the drive",)}
    assert {*live.views.published} == {"sent", "sent as invalid"}


def test_text_from_outside_is_no_markup(session, frames):
    live, _, _ = session(frames[:200])
    live.publisher.trouble = "not publishing: [/dev/ttyACM0] gone"
    console = Console(file=io.StringIO(), width=110)
    console.print(panel(live.status()))
    assert "[/dev/ttyACM0]" in console.file.getvalue()


def test_an_interface_that_cannot_be_is_the_end(session):
    Receiver.failure = SetupError("--interface nonsense: no such interface")
    try:
        with pytest.raises(SetupError, match="nonsense"):
            session([Notice("x")])
    finally:
        Receiver.failure = None


def test_what_is_said_once_is_not_said_again(session, frames):
    live, said, _ = session(frames[:100])
    live.publisher.trouble = "not publishing: OSError: gone"
    for _ in range(3):
        live._tell()
    assert said.count("not publishing: OSError: gone") == 1


def test_the_panel_has_everything_with_its_unit(session, frames):
    live, _, ticks = session(frames)
    console = Console(file=io.StringIO(), width=110, highlight=False)
    console.print(panel(live.status()))
    text = console.file.getvalue()
    for word in ("elongation", "um (2 sd)", "15 of 15 thermometers", "NIS", "frames", "dropped", "recording"):
        assert word in text
    line = live.status().line()
    assert "\n" not in line
    assert "mode update" in line or "mode predict" in line
    told = ticks[-1].json()
    assert set(told) >= {
        "t", "elongation_um", "sigma_um", "error_at_table_um", "mode", "channels", "nis", "frames", "dropped", "alarms",
        "suspects",
    }  # fmt: skip
    assert told["suspects"] == []


def test_readings_that_are_none_are_refused_and_no_frame_is_dropped(session, frames):
    """The same count for programs, for the terminal and at the end; a frame of the wrong length is dropped."""
    can_id, change = channel(5, lambda value, time_s: 32000)
    live, _, ticks = session(changed(frames, can_id, 30.0, change))
    count = ticks[-1].json()["refused"]["T05"]
    assert 13 <= count <= 16
    assert ticks[-1].json()["refused"] == {"T05": count}
    assert (ticks[-1].json()["dropped"], live.status().dropped) == (0, 0)
    assert f"{count} x out of range T05" in live.status().line()
    assert live.status().refused["T05"] - count in (0, 1)  # what came after the last tick that was told
    live, _, ticks = session(
        [f._replace(data=f.data[:7]) if f.id == DRIVE and since(frames, f) >= 30 else f for f in frames]
    )
    assert ticks[-1].json()["refused"] == {}
    assert live.status().dropped == sum(f.id == DRIVE and since(frames, f) >= 30 for f in frames)


def test_json_lines_on_a_full_disk_cost_lines_and_nothing_else(session, frames):
    class Disk(io.BytesIO):
        written, fails = 0, (1, 2)

        def write(self, line) -> int:
            self.written += 1
            if self.written - 1 in self.fails:
                raise OSError(28, "No space left on device")
            return super().write(line)

    _, _, ticks = session(frames[:400])
    disk, full = Disk(), "--json: No space left on device: lines are lost"
    lines = JsonLines(disk)
    for k, (trouble, lost) in enumerate((("", 0), (full, 1), (full, 2), ("", 2))):
        lines(ticks[k])
        until(lambda told=(k + 1, trouble, lost): told == (disk.written, lines.trouble, lines.lost))
    lines.close()
    assert json.loads(disk.getvalue().splitlines()[-1])["t"] == pytest.approx(ticks[3].moment.step.time_s, abs=1e-9)


def test_a_reader_that_stalls_holds_up_no_tick_and_gets_what_there_was_room_for(session, frames):
    _, _, ticks = session(frames[:400])
    reader, writer = os.pipe()
    asked = 0
    with open(writer, "wb", buffering=0) as file:
        lines = JsonLines(file)
        while lines.lost < WAITING:
            lines(ticks[0])
            asked += 1
        assert lines.trouble == "--json: their reader is behind: lines are lost"
        with open(reader, "rb") as late:
            texts = {late.readline() for _ in range(asked - lines.lost)}
        assert [json.loads(text)["t"] for text in texts] == [pytest.approx(ticks[0].moment.step.time_s, abs=1e-9)]
        lines.close()
        assert lines.trouble == ""


def test_before_the_first_tick_the_status_says_so(session):
    live, _, _ = session([])
    assert "waiting for the first tick" in live.status().line()
